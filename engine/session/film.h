// Makes session.mp4 from pictures and a WAV with the packaged program `ffmpeg`. Without ffmpeg, no film is made, and
// a message says so.
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
/// if the encoder is missing or fails, message() gives the reason.
class FilmWriter {
 public:
  FilmWriter(const std::filesystem::path& file, const FilmOptions& options);
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  /// Adds a frame. `rgb`: width × height × 3 bytes, rows from the top, sRGB. Returns false if no encoder is running.
  bool add(std::span<const std::uint8_t> rgb) noexcept;
  /// Adds the sound if `wav` is given, and completes the file. Returns true if the film exists; otherwise message()
  /// gives the reason.
  bool finish(const std::optional<std::filesystem::path>& wav = std::nullopt) noexcept;
  /// The reason why no film exists or why the film is incomplete; empty if the film is complete.
  const std::string& message() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Path of the encoder in PATH; no value if it is not installed.
std::optional<std::filesystem::path> find_ffmpeg();

}  // namespace typodont::session
