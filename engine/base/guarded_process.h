// Child processes that read untrusted files with libraries not built for them. The child first limits its memory, time
// and rights; the program checks all that it writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont {

/// That a child sets for itself.
struct ProcessLimits {
  std::uint64_t seconds = 60;                // s, largest processor time and largest elapsed time
  std::uint64_t memory = 1024ull << 20;      // bytes of address space, with libraries
  std::uint64_t longest_file = 64ull << 20;  // largest size of a written file, in bytes
};
/// For the calling process. Smaller limits stay.
void limit_process(const ProcessLimits& limits);

/// From here the process cannot start programs, use the network or write files. Without seccomp in the kernel, only
/// limit_process() protects.
void give_up_privileges();

/// The helper's path: $`variable`, then this program's folder, the install folder, the build folder. `what`: purpose,
/// for the message. Throws Error.
std::filesystem::path companion_program(const char* variable, const std::string& name, const char* built,
                                        const std::string& what);

/// Without environment and open files. `words`: command and arguments. Standard output to the descriptor `output`; -1:
/// /dev/null. Exit status, or -1 after a signal. Throws Error if it cannot start.
int run_guarded(const std::vector<std::string>& words, int output = -1);

}  // namespace typodont
