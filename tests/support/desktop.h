// A desktop in memory (Xvfb) for tests of real windows. A test can read the screen, and send keys and pointer motion
// through xdotool.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "engine/render/picture.h"

namespace typodont::test {

/// Starts an X server and sets DISPLAY to its name. The server ends when this object is destroyed.
struct XServer {
  pid_t process = -1;

  /// `command`: the program and its arguments, without the display number. `said`: file for the program's messages, or
  /// empty.
  explicit XServer(std::vector<std::string> command, const std::string& said = "") {
    int fds[2];
    if (pipe(fds) != 0) return;
    // The display number is random. A server that takes the first free number can lose its socket to another server
    // that ends at the same time. -noreset: a server that resets itself when its last client (a call of xdotool) leaves
    // refuses the next client for a moment. -r: a key that a slow machine releases late must not repeat.
    const unsigned display = 100 + std::random_device()() % 50000;
    command.insert(command.end(), {fmt::format(":{}", display), "-displayfd", std::to_string(fds[1]), "-nolisten",
                                   "tcp", "-noreset", "-r"});
    std::vector<char*> arguments;
    for (std::string& argument : command) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    process = fork();
    if (process == 0) {
      close(fds[0]);
      if (!said.empty() && !std::freopen(said.c_str(), "w", stderr)) _exit(126);
      execvp(arguments[0], arguments.data());
      _exit(127);
    }
    close(fds[1]);
    // The server writes its number in several parts, ended by a new line, when it accepts connections.
    std::string number;
    for (char c = 0; read(fds[0], &c, 1) == 1 && c != '\n';) number += c;
    close(fds[0]);
    setenv("DISPLAY", fmt::format(":{}", number).c_str(), 1);
    unsetenv("WAYLAND_DISPLAY");
  }
  ~XServer() {
    if (process <= 0) return;
    kill(process, SIGTERM);
    waitpid(process, nullptr, 0);
  }
  XServer(const XServer&) = delete;
  XServer& operator=(const XServer&) = delete;
};

/// A folder for the framebuffer. It is removed when this object is destroyed.
struct FramebufferFolder {
  std::filesystem::path path;
  FramebufferFolder() {
    char pattern[] = "/tmp/typodont_xvfb_XXXXXX";
    path = mkdtemp(pattern);
  }
  ~FramebufferFolder() { std::filesystem::remove_all(path); }
  FramebufferFolder(const FramebufferFolder&) = delete;
  FramebufferFolder& operator=(const FramebufferFolder&) = delete;
};

/// An Xvfb server with its framebuffer in a file (XWD format).
struct Desktop {
  FramebufferFolder folder;
  XServer server;

  explicit Desktop(glm::ivec2 size = {800, 600})
      : server({"Xvfb", "-screen", "0", fmt::format("{}x{}x24", size.x, size.y), "-fbdir", folder.path.string()}) {}

  /// Returns the upper left part of the screen as a picture.
  render::Picture screen(glm::ivec2 size) const {
    const std::filesystem::path file = folder.path / "Xvfb_screen0";
    // Tests call this function again and again, so it reads the whole file at once.
    std::vector<std::uint8_t> bytes(std::filesystem::file_size(file));
    std::ifstream(file, std::ios::binary)
        .read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    const auto word = [&](std::size_t i) {  // XWD headers are big-endian
      std::uint32_t v = 0;
      for (std::size_t k = 0; k < 4; ++k) v = v << 8 | bytes.at(4 * i + k);
      return v;
    };
    const std::size_t start = word(0) + 12 * std::size_t{word(19)}, line = word(12);
    const auto width = static_cast<std::size_t>(size.x), height = static_cast<std::size_t>(size.y);
    render::Picture p{size, std::vector<std::uint8_t>(4 * width * height, 255)};
    for (std::size_t y = 0; y < height; ++y) {
      const std::span row = std::span(bytes).subspan(start + y * line, 4 * width);
      std::uint8_t* const to = &p.rgba[4 * width * y];
      for (std::size_t i = 0; i < row.size(); i += 4) to[i] = row[i + 2], to[i + 1] = row[i + 1], to[i + 2] = row[i];
    }
    return p;
  }

  /// Runs xdotool on this desktop with these arguments and returns its output.
  static std::string xdotool(const std::string& arguments) {
    std::FILE* pipe = popen(fmt::format("xdotool {} 2>/dev/null", arguments).c_str(), "r");
    std::string out;
    char piece[256];
    while (pipe && std::fgets(piece, sizeof piece, pipe)) out += piece;
    if (pipe) pclose(pipe);
    return out;
  }
};

}  // namespace typodont::test
