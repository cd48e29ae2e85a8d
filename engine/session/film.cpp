#include "engine/session/film.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string_view>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/partial_file.h"

extern char** environ;

namespace typodont::session {

namespace {

/// Starts the program with the command `arguments`. Its standard input is the descriptor `input` (-1: no input), and
/// its standard error is the file `log`. Returns the process number, or -1 if the program cannot be started.
pid_t start(const std::vector<std::string>& arguments, int input, const std::filesystem::path& log) {
  std::vector<char*> argv;
  for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (input >= 0) {
    posix_spawn_file_actions_adddup2(&actions, input, 0);
  } else {
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  }
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  // The encoder gets its own process group, so that Ctrl-C on the terminal ends only this program. This program then
  // ends the encoder.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t pid = -1;
  const int error = posix_spawn(&pid, arguments[0].c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error == 0 ? pid : -1;
}

bool ended_well(pid_t pid) {
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return false;
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::string first_line(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

}  // namespace

std::optional<std::filesystem::path> find_ffmpeg() {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "/usr/local/bin:/usr/bin:/bin";
  while (!rest.empty()) {
    const auto colon = rest.find(':');
    const std::filesystem::path candidate = std::filesystem::path(rest.substr(0, colon)) / "ffmpeg";
    std::error_code code;
    if (std::filesystem::is_regular_file(candidate, code) && access(candidate.c_str(), X_OK) == 0) return candidate;
    if (colon == std::string_view::npos) break;
    rest.remove_prefix(colon + 1);
  }
  return std::nullopt;
}

struct FilmWriter::Impl {
  /// Paths of the temporary files that ffmpeg writes.
  struct Parts {
    explicit Parts(const std::filesystem::path& file)
        : pictures(file, FileKind::kFilm, Over::kNoInput, "pictures"),
          with_sound(file, FileKind::kFilm, Over::kNoInput, "sound"),
          log(file, FileKind::kFilm, Over::kNoInput, "log") {}
    PartialFile pictures, with_sound, log;
  };
  std::optional<Parts> parts;
  std::filesystem::path ffmpeg;
  std::size_t frame_bytes = 0;
  double fps = 0;
  std::uint64_t frames = 0;
  pid_t encoder = -1;
  int input = -1;  // descriptor to which frames are written
  std::string message;

  void open(const FilmOptions& options);
  void stop_encoder(bool& good);
  std::string complaint() const { return first_line(parts->log.path()); }
};

void FilmWriter::Impl::open(const FilmOptions& options) {
  fps = options.fps;
  const auto found = find_ffmpeg();
  if (!found) {
    message = "no film: the program ffmpeg is not installed (apt install ffmpeg)";
    return;
  }
  if (options.width < 2 || options.height < 2 || !(options.fps > 0)) {
    message = fmt::format("no film: {} x {} pixels at {} frames a second are impossible", options.width, options.height,
                          options.fps);
    return;
  }
  ffmpeg = *found;
  frame_bytes = static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height) * 4;
  // A socket is used instead of a pipe, because send() can suppress the signal SIGPIPE, which the system sends if the
  // encoder has ended.
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    message = fmt::format("no film: {}", std::strerror(errno));
    return;
  }
  encoder = start({ffmpeg.string(), "-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format",
                   "rgb0", "-video_size", fmt::format("{}x{}", options.width, options.height), "-framerate",
                   fmt::format("{}", options.fps), "-i", "pipe:0",
                   // The pixel format 4:2:0, which every player can decode, requires even width and height.
                   "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-preset", "veryfast", "-crf", "20",
                   "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", parts->pictures.path().string()},
                  ends[0], parts->log.path());
  close(ends[0]);
  if (encoder < 0) {
    close(ends[1]);
    message = fmt::format("no film: {} cannot be started", ffmpeg.string());
    return;
  }
  input = ends[1];
}

void FilmWriter::Impl::stop_encoder(bool& good) {
  if (input >= 0) close(input);
  input = -1;
  good = encoder > 0 && ended_well(encoder);
  encoder = -1;
}

FilmWriter::FilmWriter(const std::filesystem::path& file, const FilmOptions& options)
    : impl_(std::make_unique<Impl>()) {
  try {
    impl_->parts.emplace(file);
    impl_->open(options);
  } catch (const Error& error) {
    impl_->message = fmt::format("no film: {}", error.what());
  }
}

FilmWriter::~FilmWriter() {
  bool good = false;
  if (impl_->encoder > 0) impl_->stop_encoder(good);
}

bool FilmWriter::add(std::span<const std::uint8_t> rgba) noexcept {
  Impl& s = *impl_;
  if (s.input < 0) return false;
  if (rgba.size() != s.frame_bytes) {
    s.message = fmt::format("no film: a frame of {} bytes, expected {}", rgba.size(), s.frame_bytes);
    return false;
  }
  while (!rgba.empty()) {
    const ssize_t n = send(s.input, rgba.data(), rgba.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      bool good = false;
      s.stop_encoder(good);
      s.message = fmt::format("no film: ffmpeg gave up: {}", s.complaint());
      return false;
    }
    rgba = rgba.subspan(static_cast<std::size_t>(n));
  }
  ++s.frames;
  return true;
}

bool FilmWriter::finish(const std::optional<FilmSound>& sound) noexcept {
  Impl& s = *impl_;
  if (s.input < 0) {
    s.parts.reset();
    return false;
  }
  bool good = false;
  s.stop_encoder(good);
  if (!good || s.frames == 0) {
    if (s.message.empty()) {
      s.message = s.frames == 0 ? "no film: no frames" : fmt::format("no film: ffmpeg gave up: {}", s.complaint());
    }
    s.parts.reset();
    return false;
  }
  PartialFile* made = &s.parts->pictures;
  if (sound) {
    const pid_t pid = start({s.ffmpeg.string(),
                             "-hide_banner",
                             "-loglevel",
                             "error",
                             "-y",
                             "-i",
                             made->path().string(),
                             "-ss",
                             fmt::format("{:.6f}", sound->from),
                             "-i",
                             sound->wav.string(),
                             "-map",
                             "0:v",
                             "-map",
                             "1:a",
                             "-c:v",
                             "copy",
                             "-c:a",
                             "aac",
                             "-b:a",
                             "160k",
                             "-t",
                             fmt::format("{:.6f}", static_cast<double>(s.frames) / s.fps),
                             "-movflags",
                             "+faststart",
                             "-f",
                             "mp4",
                             s.parts->with_sound.path().string()},
                            -1, s.parts->log.path());
    if (pid > 0 && ended_well(pid)) {
      made = &s.parts->with_sound;
    } else {
      s.message = fmt::format("the film is silent: {}", s.complaint());
    }
  }
  try {
    made->keep();
  } catch (const Error& error) {
    s.message = fmt::format("no film: {}", error.what());
    good = false;
  }
  s.parts.reset();
  return good;
}

const std::string& FilmWriter::message() const noexcept {
  return impl_->message;
}

}  // namespace typodont::session
