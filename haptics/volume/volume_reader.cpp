// typodont-volume-reader FROM.vdb TO GRID…: copies grids in a separate process. A damaged file ends only this process.
// Memory, time and files are limited; other processes, the network and other files cannot be reached.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/guarded_process.h"
#include "haptics/volume/flat_grids.h"

namespace {

constexpr std::uint64_t kMemory = 1024ull << 20;  // bytes, memory limit of this process, including libraries
// bytes of address space allowed per byte of the file
constexpr std::uint64_t kMemoryPerByte = 200;
constexpr std::uint64_t kMaxMemory = 32ull << 30;
// largest number of bytes of output per byte of file; tissue needs less
constexpr std::uint64_t kOutputPerByte = 4096;
constexpr std::uint64_t kMinOutput = 64ull << 20;

int run(int argc, char** argv) {
  using namespace typodont;
  if (argc < 4) return 2;
  const std::string from = argv[1], to = argv[2];
  const std::vector<std::string> names(argv + 3, argv + argc);
  std::error_code code;
  const std::uint64_t bytes = std::filesystem::file_size(from, code);
  if (code) return 2;
  // The output is opened before the right to write files is given up.
  const int out = open(to.c_str(), O_WRONLY | O_CLOEXEC);
  if (out < 0) return 2;
  const std::uint64_t longest = std::max(kMinOutput, kOutputPerByte * bytes);
  const std::uint64_t memory = std::min(kMaxMemory, kMemory + kMemoryPerByte * bytes);
  limit_process({.memory = memory, .longest_file = longest});
  // Without this signal, writing beyond the limit returns an error and does not end the process.
  std::signal(SIGXFSZ, SIG_IGN);
  give_up_privileges();
  const auto too_large = [&from] {
    return std::string(
        Error(from, "", "sizes beyond what a file of its length may take", "a tissue volume (.vdb)").what());
  };
  std::string message;
  try {
    haptics::write_flat(out, to, haptics::read_vdb(from, names));
    return 0;
  } catch (const std::bad_alloc&) {
    rlimit limit{};
    getrlimit(RLIMIT_AS, &limit);
    message = limit.rlim_cur >= memory ? too_large()
                                       : Error(from, "", fmt::format("a memory limit of {} MB", limit.rlim_cur >> 20),
                                               fmt::format("{} MB, which reading this file may take", memory >> 20))
                                             .what();
  } catch (const haptics::WriteFailure&) {
    // If the output has the largest allowed length, the volume file is wrong. If the output is shorter, the disk is
    // full or the user's limit is smaller.
    const off_t written = lseek(out, 0, SEEK_END);
    if (written < 0 || static_cast<std::uint64_t>(written) < longest) return haptics::kReaderCannotWrite;
    message = too_large();
  } catch (const Error& e) {
    message = e.what();
  } catch (const std::exception& e) {
    message = Error(from, "", e.what(), "a tissue volume (.vdb)").what();
  }
  // Writes a message instead of the grids.
  if (ftruncate(out, 0) != 0 || pwrite(out, message.data(), message.size(), 0) < 0) return haptics::kReaderCannotWrite;
  return 1;
}

}  // namespace

/// Ends the process without cleanup, because a sanitizer's cleanup would use forbidden system calls.
int main(int argc, char** argv) {
  _exit(run(argc, argv));
}
