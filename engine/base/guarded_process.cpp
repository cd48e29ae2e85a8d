#include "engine/base/guarded_process.h"

#include <fcntl.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/sched.h>
#include <linux/seccomp.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <cstring>

#include "engine/base/error.h"
#include "engine/base/own_file.h"

namespace typodont {

void limit_process(const ProcessLimits& limits) {
  // Lowers a limit of this process; a limit that is already lower remains.
  const auto lower = [](auto resource, rlim_t most) {
    rlimit limit{};
    getrlimit(resource, &limit);
    limit = {std::min(limit.rlim_cur, most), std::min(limit.rlim_max, most)};
    setrlimit(resource, &limit);
  };
  lower(RLIMIT_CORE, 0);
  lower(RLIMIT_CPU, limits.seconds);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  // The address space is not limited, because a sanitizer reserves more than any useful limit.
#else
  lower(RLIMIT_AS, limits.memory);
#endif
  lower(RLIMIT_FSIZE, limits.longest_file);
  alarm(static_cast<unsigned>(limits.seconds));  // ends the process after this time, even if it sleeps
}

void give_up_privileges() {
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
#ifdef __x86_64__
  constexpr auto number = static_cast<std::uint32_t>(offsetof(seccomp_data, nr));
  constexpr auto architecture = static_cast<std::uint32_t>(offsetof(seccomp_data, arch));
  // Offset of the first argument of a system call: for clone(), the flags.
  constexpr auto first = static_cast<std::uint32_t>(offsetof(seccomp_data, args[0]));
  // Offset of the third argument of a system call: for openat(), the flags.
  constexpr auto third = static_cast<std::uint32_t>(offsetof(seccomp_data, args[2]));
  constexpr std::uint32_t kRefused = SECCOMP_RET_ERRNO | 1;  // the system call fails with EPERM (1)
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
  // OpenVDB needs threads, but new processes are forbidden. clone3() has its flags in memory, which the filter cannot
  // read. If clone3() is refused, the C library calls clone().
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

std::filesystem::path companion_program(const char* variable, const std::string& name, const char* built,
                                        const std::string& what) {
  const std::filesystem::path own = own_file().parent_path();
  const char* const set = std::getenv(variable);
  const std::filesystem::path files[] = {set ? set : "", own / name, own / "../libexec/typodont" / name,
                                         own / "../../libexec/typodont" / name, built};
  // If no file may be run, the first one is returned, so that starting it says why.
  for (const int wanted : {X_OK, F_OK})
    for (const std::filesystem::path& file : files)
      if (access(file.c_str(), wanted) == 0) return file;
  throw Error((own / name).string(), "", "no such program", what);
}

int run_guarded(const std::vector<std::string>& asked, int output) {
  std::vector<std::string> words = asked;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  // The child gets default signal handlers and no environment, because the environment may contain passwords.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t all, none;
  sigfillset(&all), sigemptyset(&none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
  // Error messages go to /dev/null: users cannot use the C library's messages about a damaged heap. Standard output
  // goes to `output` if this is given.
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  for (const int fd : {0, 1, 2}) {
    if (fd == 1 && output >= 0)
      posix_spawn_file_actions_adddup2(&actions, output, 1);
    else
      posix_spawn_file_actions_addopen(&actions, fd, "/dev/null", O_RDWR, 0);
  }
  char* const no_environment[] = {nullptr};
  pid_t child = 0;
  const int failed = posix_spawn(&child, arguments[0], &actions, &attributes, arguments.data(), no_environment);
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (failed) throw Error(words[0], "", std::strerror(failed), "a program that can be started");
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  constexpr int kNotLoaded = 127;  // exit status of the dynamic loader and of a shell if the program cannot be loaded
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotLoaded)
    throw Error(words[0], "", "a program that does not start", "its libraries, and permission to run it");
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace typodont
