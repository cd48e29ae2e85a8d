// Child processes that read untrusted files with libraries that are not safe for such files. The child first limits its
// memory, time and rights; the parent checks everything that it writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont {

/// Limits that a child process sets for itself.
struct ProcessLimits {
  std::uint64_t seconds = 60;                // s, largest processor time and largest elapsed time
  std::uint64_t memory = 1024ull << 20;      // bytes, largest address space, including libraries
  std::uint64_t longest_file = 64ull << 20;  // largest size of a written file, in bytes
};
/// Sets these limits for the calling process. Limits that are already lower remain.
void limit_process(const ProcessLimits& limits);

/// After this call, the process cannot start programs, use the network or write files. If the kernel has no seccomp,
/// only limit_process() protects.
void give_up_privileges();

/// Finds a helper program: at the path in the environment variable, else in the folder of this program, of the
/// installation or of the build. `what`: its purpose, for the message. Throws Error.
std::filesystem::path companion_program(const char* variable, const std::string& name, const char* built,
                                        const std::string& what);

/// Runs a command without environment and open files. `words`: command and arguments; `output`: descriptor for standard
/// output, -1: /dev/null. Returns the exit status, or -1 after a signal. Throws Error if it cannot start.
int run_guarded(const std::vector<std::string>& words, int output = -1);

}  // namespace typodont
