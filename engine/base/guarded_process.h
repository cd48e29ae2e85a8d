// Child processes that read untrusted files. The libraries that read these files were not built for hostile input. So a
// child process first limits its own memory, time and rights, and the program checks everything that the child process
// writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont {

/// The limits that a child process sets for itself.
struct ProcessLimits {
  std::uint64_t seconds = 60;                // s, largest processor time and largest elapsed time
  std::uint64_t memory = 1024ull << 20;      // bytes, largest address space, including the space of libraries
  std::uint64_t longest_file = 64ull << 20;  // largest size of a written file, in bytes
};
/// Sets these limits for the calling process. Limits that are already smaller remain.
void limit_process(const ProcessLimits& limits);

/// The calling process gives up rights: from now on, it cannot start programs or use the network, and can open files
/// only for reading. If the kernel has no system call filters (seccomp), the process keeps these rights, and only
/// limit_process() protects the user.
void give_up_privileges();

/// Finds a helper program and returns its path. The search order is: the path in the environment variable `variable`,
/// this program's folder, the install folder, the build folder. `what` names the helper's purpose in the error message.
/// Throws Error.
std::filesystem::path companion_program(const char* variable, const std::string& name, const char* built,
                                        const std::string& what);

/// Runs a program as a new process without environment variables and without this process's open files. `words` are the
/// command and its arguments. The program's standard output goes to the descriptor `output`, or to /dev/null if
/// `output` is -1. Returns the exit status, or -1 if a signal ended the program. Throws Error if the program cannot be
/// started.
int run_guarded(const std::vector<std::string>& words, int output = -1);

}  // namespace typodont
