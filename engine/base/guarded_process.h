// Processes that read what others made with libraries that trust their input: little memory, little time, no way to do
// harm. The program starts one, which limits itself; what it says is checked.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace typodont {

/// What a process may use from now on.
struct ProcessLimits {
  std::uint64_t seconds = 60;                // of processor time, and by the clock
  std::uint64_t memory = 1024ull << 20;      // bytes of addresses, the libraries' included
  std::uint64_t longest_file = 64ull << 20;  // bytes that one file that it writes may have
};
/// Called by the process itself.
void limit_process(const ProcessLimits& limits);

/// After this the process can start nothing, send nothing, and open files for reading only. Where the kernel has no
/// filters, the limits are all. Called by the process itself.
void give_up_privileges();

/// A program that comes with this one: as the environment variable says, beside this program, where it was installed,
/// or where it was built. `what`: what it does, for the message. Throws Error.
std::filesystem::path companion_program(const char* variable, const std::string& name, const char* built,
                                        const std::string& what);

/// Runs a program as a fresh process that shares nothing with this one and has no environment. Its words go to
/// `output` where that is a descriptor. Its exit status; -1 where a signal ended it. Throws Error where it cannot be
/// started.
int run_guarded(const std::vector<std::string>& words, int output = -1);

}  // namespace typodont
