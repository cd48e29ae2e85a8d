// session.mp4 from pictures and a WAV, through the packaged `ffmpeg` program. Without it there is no film, and a
// message.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace typodont::session {

struct FilmOptions {
  int width = 1280, height = 720;  // pixels of a frame
  double fps = 30;
};

/// One thread. Frames are compressed while they come; the film appears in finish(), whole or not at all. Nothing
/// throws: a missing or failing encoder is a message.
class FilmWriter {
 public:
  FilmWriter(const std::filesystem::path& file, const FilmOptions& options);
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  /// width × height × 3 bytes, rows from the top, sRGB. False when there is no encoder (any more).
  bool add(std::span<const std::uint8_t> rgb) noexcept;
  /// Adds the sound if there is one, and makes the file. True when the film is there; else see message().
  bool finish(const std::optional<std::filesystem::path>& wav = std::nullopt) noexcept;
  /// Why there is no film, or what is missing in it; empty when all is well.
  const std::string& message() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The encoder in PATH, if any.
std::optional<std::filesystem::path> find_ffmpeg();

}  // namespace typodont::session
