// Child processes that read untrusted files with libraries that were not built for hostile input. They run with little
// memory, little time and no rights to do harm. The program starts such a process, the process limits itself, and the
// program checks its output.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont {

/// Limits that a process sets for itself.
struct ProcessLimits {
  std::uint64_t seconds = 60;                // limit for the processor time and for the elapsed time
  std::uint64_t memory = 1024ull << 20;      // bytes of address space, including the space of libraries
  std::uint64_t longest_file = 64ull << 20;  // bytes, largest size of one written file
};
/// Call in the process that is to be limited.
void limit_process(const ProcessLimits& limits);

/// After this call the process cannot start programs or use the network, and can open files only for reading. If the
/// kernel has no seccomp filters, only limit_process() protects. Call in the process that is to be limited.
void give_up_privileges();

/// Path of a helper program. Searched in this order: the path in the environment variable, this program's folder, the
/// install folder, the build folder. `what` names the helper's purpose in the error message. Throws Error.
std::filesystem::path companion_program(const char* variable, const std::string& name, const char* built,
                                        const std::string& what);

/// Runs a program as a new process that shares nothing with this one and has no environment variables. `words` are the
/// command and its arguments. The program's standard output goes to the descriptor `output`, or to /dev/null if
/// `output` is -1. Returns the exit status; -1 if a signal ended the program. Throws Error if the program cannot be
/// started.
int run_guarded(const std::vector<std::string>& words, int output = -1);

}  // namespace typodont
