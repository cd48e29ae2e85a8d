// Makes the film session.mp4 from pictures and a WAV file, with the installed program `ffmpeg`. If ffmpeg is missing,
// no film is made, and a message states this.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace typodont::session {

struct FilmOptions {
  int width = 1280, height = 720;  // pixels, width and height of a frame of the film
  double fps = 30;
};

/// The sound of a film.
struct FilmSound {
  std::filesystem::path wav;
  double from = 0;  // s, the WAV file's time at the film's first frame
};

/// Writes a film. Used by one thread. Frames are compressed as they arrive, and finish() creates the film completely or
/// not at all. Never throws: if the encoder is missing or fails, message() states the reason.
class FilmWriter {
 public:
  FilmWriter(const std::filesystem::path& file, const FilmOptions& options);
  ~FilmWriter();
  FilmWriter(const FilmWriter&) = delete;
  FilmWriter& operator=(const FilmWriter&) = delete;

  /// Adds a frame. `rgba`: width × height × 4 bytes in sRGB, the top row first; alpha is ignored. False if no encoder
  /// is running.
  bool add(std::span<const std::uint8_t> rgba) noexcept;
  /// Adds the sound if given, and completes the file. True if the film exists; otherwise message() states the reason.
  bool finish(const std::optional<FilmSound>& sound = std::nullopt) noexcept;
  /// States why no film exists or why the film is incomplete. Empty if the film is complete.
  const std::string& message() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The path of the program ffmpeg, found with the variable PATH; no value if it is not installed.
std::optional<std::filesystem::path> find_ffmpeg();

}  // namespace typodont::session
