// A desktop in memory (Xvfb) for tests of real windows: what is on the screen, and keys and pointer through xdotool.
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
#include <string>
#include <vector>

#include "engine/render/picture.h"

namespace typodont::test {

/// Xvfb with its framebuffer in a file (XWD format), gone with this object.
struct Desktop {
  pid_t process = -1;
  std::filesystem::path folder;

  explicit Desktop(glm::ivec2 size = {800, 600}) {
    char pattern[] = "/tmp/typodont_xvfb_XXXXXX";
    folder = mkdtemp(pattern);
    int fds[2];
    if (pipe(fds) != 0) return;
    process = fork();
    if (process == 0) {
      close(fds[0]);
      const std::string fd = std::to_string(fds[1]), screen = fmt::format("{}x{}x24", size.x, size.y);
      execlp("Xvfb", "Xvfb", "-displayfd", fd.c_str(), "-screen", "0", screen.c_str(), "-fbdir", folder.c_str(),
             "-nolisten", "tcp", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(fds[1]);
    // It says its number in several writes, the last a new line, once it takes connections.
    std::string number;
    for (char c = 0; read(fds[0], &c, 1) == 1 && c != '\n';) number += c;
    close(fds[0]);
    setenv("DISPLAY", fmt::format(":{}", number).c_str(), 1);
    unsetenv("WAYLAND_DISPLAY");
  }
  ~Desktop() {
    if (process > 0) {
      kill(process, SIGTERM);
      waitpid(process, nullptr, 0);
    }
    std::filesystem::remove_all(folder);
  }
  Desktop(const Desktop&) = delete;
  Desktop& operator=(const Desktop&) = delete;

  /// The upper left part of the screen.
  render::Picture screen(glm::ivec2 size) const {
    std::ifstream in(folder / "Xvfb_screen0", std::ios::binary);
    const std::vector<char> bytes((std::istreambuf_iterator<char>(in)), {});
    const auto word = [&](std::size_t i) {  // XWD headers are big-endian
      std::uint32_t v = 0;
      for (std::size_t k = 0; k < 4; ++k) v = v << 8 | static_cast<std::uint8_t>(bytes.at(4 * i + k));
      return v;
    };
    const std::size_t start = word(0) + 12 * std::size_t{word(19)}, line = word(12);
    render::Picture p{size, {}};
    for (int y = 0; y < size.y; ++y)
      for (int x = 0; x < size.x; ++x) {
        const std::size_t at = start + static_cast<std::size_t>(y) * line + 4 * static_cast<std::size_t>(x);
        for (std::size_t c : {2, 1, 0}) p.rgba.push_back(static_cast<std::uint8_t>(bytes.at(at + c)));
        p.rgba.push_back(255);
      }
    return p;
  }

  /// xdotool with these arguments; its output. DISPLAY is this desktop's since it was made.
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
