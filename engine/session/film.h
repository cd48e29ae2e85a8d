// Makes session.mp4 from pictures and a WAV with the packaged program `ffmpeg`. Without ffmpeg there is no film but a
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

/// One thread. Frames are compressed as they arrive; finish() creates the film completely or not at all. Never throws:
/// a missing or failing encoder results in a message.
class FilmWriter {
 public:
  FilmWriter(const std::filesystem::path& file, const FilmOptions& options);
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  /// `rgb`: width × height × 3 bytes, rows from the top, sRGB. False if there is no running encoder.
  bool add(std::span<const std::uint8_t> rgb) noexcept;
  /// Adds the sound if there is one, and makes the file. True when the film is there; else see message().
  bool finish(const std::optional<std::filesystem::path>& wav = std::nullopt) noexcept;
  /// The reason why there is no film or why it is incomplete; empty if it is complete.
  const std::string& message() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The encoder in PATH, if there is one.
std::optional<std::filesystem::path> find_ffmpeg();

}  // namespace typodont::session
