// typodont-volume-reader FROM.vdb TO GRID…: the guarded process that reads volume files. OpenVDB trusts its files: a
// damaged length costs gigabytes, a damaged tree the heap. Here both end in an exit status: memory, time and files are
// limited, and the process may start nothing, reach no network and change no other file.
#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "haptics/volume/flat_grids.h"

namespace {

constexpr rlim_t kSeconds = 60;                   // of its own, and by the clock
constexpr std::uint64_t kMemory = 1024ull << 20;  // bytes of addresses, the libraries' included, and …
constexpr std::uint64_t kMemoryPerByte = 200;     // … for each byte of the file
constexpr std::uint64_t kMostMemory = 32ull << 30;
constexpr std::uint64_t kOutputPerByte = 4096;  // bytes written for each read; more is no tissue
constexpr std::uint64_t kLeastOutput = 64ull << 20;

void limit(std::uint64_t file_bytes) {
  const std::uint64_t memory = std::min(kMostMemory, kMemory + kMemoryPerByte * file_bytes);
  const std::uint64_t output = std::max(kLeastOutput, kOutputPerByte * file_bytes);
  const rlimit none{0, 0}, seconds{kSeconds, kSeconds}, bytes{memory, memory}, longest{output, output};
  setrlimit(RLIMIT_CORE, &none);
  setrlimit(RLIMIT_CPU, &seconds);
  setrlimit(RLIMIT_AS, &bytes);
  setrlimit(RLIMIT_FSIZE, &longest);
  alarm(kSeconds);  // and where it sleeps for ever
}

/// After this it can start nothing, send nothing, and open files for reading only. Where the kernel has no filters, the
/// limits are all.
void give_up_privileges() {
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
#ifdef __x86_64__
  constexpr auto number = static_cast<std::uint32_t>(offsetof(seccomp_data, nr));
  constexpr auto architecture = static_cast<std::uint32_t>(offsetof(seccomp_data, arch));
  constexpr auto first = static_cast<std::uint32_t>(offsetof(seccomp_data, args[0]));  // of clone: its flags
  constexpr auto third = static_cast<std::uint32_t>(offsetof(seccomp_data, args[2]));  // of openat: its flags
  constexpr std::uint32_t kRefused = SECCOMP_RET_ERRNO | 1;                            // EPERM
  std::vector<sock_filter> filter = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, architecture),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AUDIT_ARCH_X86_64, 1, 0),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_KILL_PROCESS),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, number),
  };
  for (const long call : {SYS_execve,
                          SYS_execveat,
                          SYS_fork,
                          SYS_vfork,
                          SYS_socket,
                          SYS_connect,
                          SYS_ptrace,
                          SYS_kill,
                          SYS_unlink,
                          SYS_unlinkat,
                          SYS_rename,
                          SYS_renameat,
                          SYS_renameat2,
                          SYS_link,
                          SYS_linkat,
                          SYS_symlink,
                          SYS_symlinkat,
                          SYS_mkdir,
                          SYS_mkdirat,
                          SYS_rmdir,
                          SYS_truncate,
                          SYS_chmod,
                          SYS_fchmodat,
                          SYS_chown,
                          SYS_fchownat,
                          SYS_mount,
                          SYS_open,
                          SYS_creat,
                          SYS_openat2,
                          SYS_io_uring_setup,
                          SYS_process_vm_writev,
                          SYS_bpf,
                          SYS_keyctl,
                          SYS_setxattr,
                          SYS_mknod,
                          SYS_mknodat}) {
    filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, static_cast<std::uint32_t>(call), 0, 1));
    filter.push_back(BPF_STMT(BPF_RET | BPF_K, kRefused));
  }
  // Threads, which OpenVDB makes, and no processes. The flags of clone3 lie in memory: without it, clone is called.
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clone3, 0, 1));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | ENOSYS));
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clone, 0, 4));
  filter.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, first));
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, CLONE_THREAD, 1, 0));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, kRefused));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_openat, 0, 3));
  filter.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, third));
  filter.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, O_WRONLY | O_RDWR | O_CREAT | O_TRUNC, 0, 1));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, kRefused));
  filter.push_back(BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW));
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  using namespace typodont;
  if (argc < 4) return 2;
  const std::string from = argv[1], to = argv[2];
  const std::vector<std::string> names(argv + 3, argv + argc);
  std::error_code code;
  const std::uint64_t bytes = std::filesystem::file_size(from, code);
  if (code) return 2;
  // Opened before it may open nothing more for writing.
  const int out = open(to.c_str(), O_WRONLY | O_CLOEXEC);
  if (out < 0) return 2;
  limit(bytes);
  give_up_privileges();
  std::string message;
  try {
    haptics::write_flat(out, to, haptics::read_vdb(from, names));
    return 0;
  } catch (const std::bad_alloc&) {
    message = Error(from, "", "sizes beyond what a file of its length may take", "a tissue volume (.vdb)").what();
  } catch (const haptics::WriteFailure&) {
    return haptics::kReaderCannotWrite;
  } catch (const Error& e) {
    message = e.what();
  } catch (const std::exception& e) {
    message = Error(from, "", e.what(), "a tissue volume (.vdb)").what();
  }
  // In place of the grids.
  if (ftruncate(out, 0) != 0 || pwrite(out, message.data(), message.size(), 0) < 0) return haptics::kReaderCannotWrite;
  return 1;
}
