// Tests processes that press with an arm and then end: many are killed, and some end in each other way (in ./run stress
// a thousand in each way). The end comes at a random moment while there is a force. The arms are emulated boards whose
// firmware never switches the motors off. So only the process itself or its watchdog can end the force. The boards are
// connected by sockets. Pseudo-terminals pass their data on by a kernel thread of ordinary priority, which a busy
// machine delays by milliseconds, and the process would lose its arm.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <random>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "engine/base/check.h"
#include "engine/base/clock.h"
#include "engine/base/realtime.h"
#include "haptics/device_safety.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/safe_device.h"
#include "haptics/devices/woodenhaptics.h"
#include "tests/support/campaign.h"
#include "tests/support/emulation/haply_service.h"

namespace typodont::haptics {
namespace {

constexpr int kTimes = 1000;
constexpr std::size_t kAtOnce = 10;

/// A process on each core, with the priority of a watchdog process, which only wakes every millisecond. Its delays show
/// how much the machine itself adds to the times that are measured here.
class Witness {
 public:
  Witness() {
    cpu_set_t mine;
    CPU_ZERO(&mine);
    ::sched_getaffinity(0, sizeof mine, &mine);
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (!CPU_ISSET(core, &mine)) continue;
      void* memory = ::mmap(nullptr, sizeof(Log), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
      if (memory == MAP_FAILED) throw std::bad_alloc();
      Log* log = new (memory) Log;
      const pid_t child = ::fork();
      if (child == 0) watch(core, *log);
      cores_.push_back({log, child});
    }
  }
  ~Witness() {
    for (const Core& core : cores_) {
      ::kill(core.child, SIGKILL);
      ::waitpid(core.child, nullptr, 0);
      ::munmap(core.log, sizeof(Log));
    }
  }
  Witness(const Witness&) = delete;
  Witness& operator=(const Witness&) = delete;

  /// Returns true if one of these processes woke late between two moments. Both moments must be some time ago.
  bool was_late(Nanos from, Nanos to) const {
    for (const Core& core : cores_) {
      for (std::size_t i = 0; i < std::min<std::size_t>(core.log->count, kMost); ++i) {
        if (core.log->late[i].woke >= from && core.log->late[i].due <= to) return true;
      }
    }
    return false;
  }

 private:
  static constexpr Nanos kLate = 3'000'000;  // ns
  static constexpr std::size_t kMost = 1 << 16;
  struct Late {
    Nanos due, woke;
  };
  struct Log {
    std::atomic<std::size_t> count{0};
    std::array<Late, kMost> late{};
  };
  struct Core {
    Log* log;
    pid_t child;
  };

  [[noreturn]] static void watch(int core, Log& log) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // a test that is killed leaves nothing running
    enter_realtime({.priority = 85, .core = core, .lock_memory = false});
    for (Nanos due = now();;) {
      due = std::max(due, now()) + 1'000'000;
      const timespec until{due / kNanosPerSecond, due % kNanosPerSecond};
      ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      const Nanos woke = now();
      if (woke - due < kLate) continue;
      log.late[log.count % kMost] = {due, woke};
      ++log.count;
    }
  }

  std::vector<Core> cores_;
};

/// The connection to an arm's board. `kept`: the link gives the watchdog process its descriptor. Otherwise no watchdog
/// process guards this arm.
class BoardLink : public Link {
 public:
  BoardLink(Descriptor fd, bool kept) : fd_(kept ? fd.get() : -1), link_(link_over(std::move(fd))) {}
  int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override { return link_->read(buffer, timeout); }
  bool write(std::span<const std::uint8_t> bytes) noexcept override { return link_->write(bytes); }
  int descriptor() const noexcept override { return fd_; }

 private:
  int fd_;
  std::unique_ptr<Link> link_;
};

std::atomic<bool> pressing{false};

void throw_from_a_thread() {
  std::thread([] { throw 1; }).join();
}

int overflow_the_stack(int depth) {
  volatile char much[4096];
  much[0] = static_cast<char>(depth);
  return depth < 0 ? 0 : overflow_the_stack(depth + 1) + much[0];
}

/// Time that this machine needs to map a page of memory, divided by 5 µs; at least 1. The kernel maps pages for a stack
/// that overflows, and frees those of a killed process before its watchdog learns of the end.
double slowness_of_memory() {
  constexpr std::size_t kPages = 2048, kPage = 4096;
  void* memory = ::mmap(nullptr, kPages * kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  ::madvise(memory, kPages * kPage, MADV_NOHUGEPAGE);
  const Nanos begin = now();
  for (std::size_t i = 0; i < kPages; ++i) static_cast<volatile char*>(memory)[i * kPage] = 1;
  const double each = to_seconds(now() - begin) / kPages;
  ::munmap(memory, kPages * kPage);
  return std::max(1.0, each / 5e-6);
}

/// A way in which a process ends.
struct Way {
  std::string_view name;
  int signal = 0;
  bool kept = false;    // the process can do nothing about it; its watchdog process can
  double usual_ms = 2;  // median time until the force is zero, on a machine that maps a page in 5 µs
};
constexpr Way kKilled{"SIGKILL", SIGKILL, true};
constexpr std::array kOtherWays{Way{"exit"},
                                Way{"quick_exit"},
                                Way{"_exit", 0, true},
                                Way{"abort"},
                                Way{"exception"},
                                Way{"check"},
                                Way{"stack overflow", 0, false, 20},  // filling eight megabytes takes its time
                                Way{"SIGSTOP", SIGSTOP, true, 20},    // ten of them are the watchdog process's patience
                                Way{"SIGTERM", SIGTERM},
                                Way{"SIGINT", SIGINT},
                                Way{"SIGHUP", SIGHUP},
                                Way{"SIGQUIT", SIGQUIT},
                                Way{"SIGSEGV", SIGSEGV},
                                Way{"SIGBUS", SIGBUS},
                                Way{"SIGFPE", SIGFPE},
                                Way{"SIGILL", SIGILL},
                                Way{"SIGPIPE", SIGPIPE},
                                Way{"SIGALRM", SIGALRM},
                                Way{"SIGUSR1", SIGUSR1},
                                Way{"SIGXCPU", SIGXCPU}};

/// The program of the child process: it presses as soon as there may be a force, and then ends in the given way.
/// `ends_at`: receives the time at which the end begins, for the parent process.
[[noreturn]] void press(const std::function<std::unique_ptr<HapticDevice>()>& open, const Way& end, unsigned seed,
                        std::atomic<Nanos>& ends_at) {
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // stopped, it would outlive a test that is killed
  ::dup2(::open("/dev/null", O_WRONLY), 2);
  for (const Way& way : kOtherWays) {
    if (way.signal != 0) ::signal(way.signal, SIG_DFL);  // whatever started us ignores
  }
  // Runs after the guard's exit function, and ends the process there. Otherwise exit() would hang in libraries that
  // wait for threads, because a forked process does not have these threads.
  std::atexit(+[] { ::_exit(0); });
  static SafeDevice* hand = nullptr;  // never destroyed: it shall not be what lets go
  try {
    auto device = open();
    auto options = SafeDevice::options_for(device->info());
    if (!end.kept) options.limits.silence = 100;  // nor shall the watchdog be
    hand = new SafeDevice(std::move(device), options);
  } catch (const std::exception&) {
    ::_exit(98);
  }
  std::thread([] {
    // The priority of the program's servo. Without it, this thread waits for other programs on a busy machine, so that
    // the watchdog takes the force away before the end that is tested.
    enter_realtime({.priority = 80, .core = -1, .lock_memory = false});
    HandSample sample;
    for (int armed = 0; hand->read(sample);) {
      hand->write(hand->armed() ? dvec3(0, 0, 3) : dvec3(0), dvec3(0));
      armed = hand->armed() ? armed + 1 : 0;
      pressing = armed > 5;  // past the first fractions of a milliampere
    }
    ::_exit(97);
  }).detach();
  std::mt19937 random(seed);
  const auto moment = static_cast<useconds_t>(random() % 40'000);
  for (bool waited = false; !waited;) {
    for (int i = 0; i < 100'000 && !pressing; ++i) ::usleep(500);
    ::usleep(moment);
    waited = pressing;
  }
  if (end.signal == SIGKILL) {
    for (;;) ::sleep(10);
  }
  // An ordinary thread may have to wait for its turn; until then the servo continues and sets the force. The test
  // measures only the time after the thread has its turn.
  enter_realtime({.priority = 85, .core = -1, .lock_memory = false});
  ends_at = now();
  if (end.signal != 0) ::kill(::getpid(), end.signal);
  if (end.name == "exit") std::exit(0);
  if (end.name == "quick_exit") std::quick_exit(0);
  if (end.name == "_exit") ::_exit(0);
  if (end.name == "abort") std::abort();
  if (end.name == "exception") throw_from_a_thread();
  if (end.name == "stack overflow") overflow_the_stack(0);
  if (end.name == "check") {
    set_check_handler(release_all_devices);
    TYPODONT_CHECK(end.name.empty());
  }
  for (;;) ::sleep(10);
}

/// `line`: this end of the connection to the arm's board.
std::unique_ptr<HapticDevice> open_arm(int line, const Arm& arm, bool kept) {
  auto link = std::make_unique<BoardLink>(Descriptor(::dup(line)), kept);
  const ArmHello hello = greet_arm(*link, true, "emulated");
  return make_arm_device(std::move(link), hello.protocol, arm, {"woodenhaptics:emulated", arm.name, ""});
}

/// While it exists, the calling thread has real-time priority, because the firmware of a board is never late. Child
/// processes that end meanwhile stay zombies until it is destroyed, and are removed at ordinary priority. The kernel
/// does not sleep while it removes a process that another program looks up in /proc, so with real-time priority the
/// other program may never get the processor.
class FirmwarePriority {
 public:
  FirmwarePriority() { enter_realtime({.priority = 82, .core = -1, .lock_memory = false}); }
  ~FirmwarePriority() {
    const sched_param ordinary{};
    ::sched_setscheduler(0, SCHED_OTHER, &ordinary);
    for (const pid_t child : ended_) ::waitpid(child, nullptr, 0);
  }
  FirmwarePriority(const FirmwarePriority&) = delete;
  FirmwarePriority& operator=(const FirmwarePriority&) = delete;

  /// Returns true if the child process has ended, and writes how it ended to `how`. Call it at most once after the end.
  bool has_ended(pid_t child, siginfo_t& how) { return look(child, how, WNOHANG); }
  void kill(pid_t child) {
    siginfo_t how;
    ::kill(child, SIGKILL);
    look(child, how, 0);
  }

 private:
  bool look(pid_t child, siginfo_t& how, int options) {
    how = {};
    ::waitid(P_PID, static_cast<id_t>(child), &how, WEXITED | WNOWAIT | options);
    if (how.si_pid != child) return false;
    ended_.push_back(child);
    return true;
  }

  std::vector<pid_t> ended_;
};

/// An arm's board at the other end of a connection, and the process that presses with this arm.
struct Victim {
  Descriptor board, line;  // the line is kept open here, so that the connection does not end with the process
  pid_t pid = -1;
  Nanos begun = 0;
  Way way;
  std::string in;
  double current = 0;  // A, the largest commanded last
  bool asked = false;  // a command came; the report is due
  Nanos answered = 0;
  std::atomic<Nanos>* ends_at = nullptr;  // shared with it: when its end began, by itself or by our hand
  Nanos kill_at = 0, zero = 0;            // zero: since when there is no force
  bool forced = false;                    // there was a force
  bool gone = false;
  siginfo_t how{};  // how the process ended, once it is gone

  /// Returns true if the process lost its arm before its end began, because the machine stalled. Such a process does
  /// not count, but its force must be zero all the same.
  bool lost_its_arm() const { return how.si_code == CLD_EXITED && (how.si_status == 97 || how.si_status == 98); }
  void hear() {
    char buffer[4096];
    for (;;) {
      pollfd waiting{board.get(), POLLIN, 0};
      if (::poll(&waiting, 1, 0) <= 0 || !(waiting.revents & POLLIN)) break;
      const ssize_t n = ::read(board.get(), buffer, sizeof buffer);
      if (n <= 0) break;
      in.append(buffer, static_cast<std::size_t>(n));
    }
    for (std::size_t end; (end = in.find('\n')) != std::string::npos; in.erase(0, end + 1)) {
      int mA[3];
      if (std::sscanf(in.c_str(), "[%d,%d,%d]", &mA[0], &mA[1], &mA[2]) != 3) continue;
      asked = true;
      current = 1e-3 * std::max({std::abs(mA[0]), std::abs(mA[1]), std::abs(mA[2])});
      forced |= current > 0;
      if (current > 0) zero = 0;
      if (current == 0 && zero == 0 && *ends_at != 0) zero = now();
    }
  }
  void answer() {
    if (!asked || now() < answered + 1'000'000) return;
    constexpr std::string_view kReport = "[3,0,0,0,0,0,0,0]\n";  // at home, where it was put
    [[maybe_unused]] const auto n = ::write(board.get(), kReport.data(), kReport.size());
    answered = now();
    asked = false;
  }
};

class Ends : public testing::Test {
 protected:
  void begin(Victim& v, const Way& way) {
    std::atomic<Nanos>* const shared = v.ends_at ? v.ends_at : new_shared();
    v = {};
    v.ends_at = shared;
    *v.ends_at = 0;
    int ends[2];
    ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    v.board = Descriptor(ends[0]), v.line = Descriptor(ends[1]);
    v.begun = now();
    v.way = way;
    const auto seed = static_cast<unsigned>(random());
    v.pid = ::fork();
    if (v.pid == 0) press([&] { return open_arm(ends[1], arm, way.kept); }, way, seed, *v.ends_at);
  }
  static std::atomic<Nanos>* new_shared() {
    void* memory =
        ::mmap(nullptr, sizeof(std::atomic<Nanos>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::bad_alloc();
    return new (memory) std::atomic<Nanos>;
  }
  enum class Outcome { kNotYet, kDone, kAgain };
  /// Carries out the given ends. `watch` is called repeatedly for each process that is alive or has died since the last
  /// call.
  template <class Watch>
  void campaign(std::vector<Way> ends, Watch watch) {
    FirmwarePriority firmware;
    std::reverse(ends.begin(), ends.end());
    const std::size_t most_again = ends.size() / 5 + 2;
    std::size_t again = 0, alive = 0;
    std::vector<Victim> victims(kAtOnce);
    while (!ends.empty() || alive > 0) {
      for (Victim& v : victims) {
        if (v.pid >= 0 || ends.empty()) continue;
        begin(v, ends.back());
        if (HasFatalFailure()) return;
        ends.pop_back();
        ++alive;
      }
      std::array<pollfd, kAtOnce> waiting;
      for (std::size_t i = 0; i < kAtOnce; ++i) waiting[i] = {victims[i].board.get(), POLLIN, 0};
      const timespec pause{0, 300'000};
      ::ppoll(waiting.data(), waiting.size(), &pause, nullptr);
      for (Victim& v : victims) {
        if (v.pid < 0) continue;
        if (!v.gone) v.gone = firmware.has_ended(v.pid, v.how);
        v.hear();  // after it was seen to be gone: all that it said is heard
        v.answer();
        const Outcome outcome = watch(v);
        if (outcome == Outcome::kNotYet) continue;
        if (outcome == Outcome::kAgain) {
          ends.push_back(v.way);
          ASSERT_LE(++again, most_again) << "too many lose their arm before their time";
        }
        if (!v.gone) firmware.kill(v.pid);
        v.pid = -1;
        --alive;
      }
    }
    for (Victim& v : victims) {
      if (v.ends_at) ::munmap(v.ends_at, sizeof(std::atomic<Nanos>));
    }
  }

  struct Took {
    Nanos from, to;
  };
  /// Checks that half of the ends are as fast as usual. Returns how many took longer than 20 ms although the machine
  /// itself was not late.
  int expect_soon(const Way& way, const std::vector<Took>& times) const {
    EXPECT_FALSE(times.empty()) << way.name;
    if (times.empty()) return 0;
    int late = 0, excused = 0;
    std::vector<double> took;
    for (const auto& [from, to] : times) {
      took.push_back(1e3 * to_seconds(to - from));
      if (took.back() <= 20) continue;
      ++(witness.was_late(from, to) ? excused : late);
    }
    std::sort(took.begin(), took.end());
    fmt::print(
        "{:<15} {:>5} times: zero after {:6.2f} ms in the median, {:6.2f} ms 99 %, {:6.2f} ms worst; {} beyond 20 ms "
        "while this machine was late itself\n",
        way.name, took.size(), took[took.size() / 2], took[took.size() * 99 / 100], took.back(), excused);
    EXPECT_LE(took[took.size() / 2], slowness * way.usual_ms) << way.name;
    return late;
  }

  const Witness witness;
  const double slowness = slowness_of_memory();
  const Arm arm = read_arm("assets/devices/woody.json");
  std::mt19937 random{1};
};

TEST_F(Ends, AfterAKillTheWatchdogSendsZeroWithinTwentyMilliseconds) {
  std::vector<Took> times;
  const auto kills = static_cast<std::size_t>(std::min(kTimes, test::campaign(200)));
  campaign(std::vector<Way>(kills, kKilled), [&](Victim& v) {
    if (*v.ends_at == 0) {
      if (v.gone) {
        EXPECT_TRUE(v.lost_its_arm() && v.current == 0);
        return Outcome::kAgain;
      }
      if (v.current <= 0) return Outcome::kNotYet;
      if (v.kill_at == 0) v.kill_at = now() + static_cast<Nanos>(random() % 40'000'000);
      if (now() < v.kill_at) return Outcome::kNotYet;
      *v.ends_at = now();
      ::kill(v.pid, SIGKILL);
      return Outcome::kNotYet;
    }
    if (!v.gone || v.zero == 0) return now() - *v.ends_at > 30 * kNanosPerSecond ? Outcome::kDone : Outcome::kNotYet;
    times.push_back({*v.ends_at, v.zero});
    return Outcome::kDone;
  });
  ASSERT_EQ(times.size(), kills);  // every single one was let go
  ::usleep(50'000);
  EXPECT_EQ(expect_soon(kKilled, times), 0);
}

TEST_F(Ends, EveryOtherEndOfAProcessSendsZeroLastAndSoon) {
  const int each = std::min(kTimes, test::campaign(20));
  std::map<std::string_view, std::vector<Took>> times;
  std::vector<Way> ends;
  for (int i = 0; i < each; ++i) ends.insert(ends.end(), kOtherWays.begin(), kOtherWays.end());
  campaign(std::move(ends), [&](Victim& v) {
    const bool ending = *v.ends_at != 0;
    if (v.way.signal == SIGSTOP && ending && v.current == 0 && now() - *v.ends_at > 50'000'000 && !v.gone)
      ::kill(v.pid, SIGKILL);
    const bool waits_for_its_watchdog = v.way.kept && ending && v.current != 0;
    if (!v.gone || waits_for_its_watchdog) {
      if (v.begun + 60 * kNanosPerSecond > now()) return Outcome::kNotYet;
      ADD_FAILURE() << v.way.name << (v.gone ? " left a force" : " did not end it");
      return Outcome::kDone;
    }
    EXPECT_EQ(v.current, 0) << v.way.name << " left a force";
    if (!ending) {
      EXPECT_TRUE(v.lost_its_arm()) << v.way.name;
      return Outcome::kAgain;
    }
    EXPECT_TRUE(v.forced) << v.way.name;
    if (v.zero == 0) return Outcome::kAgain;  // its watchdog had let go just before: there was nothing to end
    times[v.way.name].push_back({*v.ends_at, v.zero});
    return Outcome::kDone;
  });
  ::usleep(50'000);
  // Ten processes run at the same time, beside other work of the machine. Sometimes the scheduler delays one of them on
  // a core where no witness process notices it. No force may remain, and at most one end in a hundred may be late.
  int late = 0;
  for (const Way& way : kOtherWays) late += expect_soon(way, times[way.name]);
  EXPECT_LE(late, std::max(1, each * static_cast<int>(kOtherWays.size()) / 100));
}

/// A minimal version of Haply's service: it answers every force with a state, and keeps the last force.
TEST(HaplyEnds, AKilledOrStoppedProcessLeavesNoForceInTheService) {
  FirmwarePriority service_priority;  // other programs cannot delay the answers
  const Descriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof address;
  ASSERT_EQ(::bind(listener.get(), reinterpret_cast<sockaddr*>(&address), length), 0);
  ASSERT_EQ(::listen(listener.get(), 1), 0);
  ASSERT_EQ(::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &length), 0);
  const int port = ntohs(address.sin_port);
  std::mt19937 random(2);
  std::atomic<Nanos> nothing{0};
  for (int i = 0; i < 100; ++i) {
    const pid_t child = ::fork();
    if (child == 0) {
      press(
          [&] {
            return make_haply(connect_tcp("127.0.0.1", port), "127.0.0.1", {"haply:", "Haply Inverse3", ""});
          },
          kKilled, static_cast<unsigned>(i), nothing);
    }
    const Descriptor client(::accept(listener.get(), nullptr, nullptr));
    test::HaplyService service;
    bool connected = true;
    const auto serve = [&] {
      char buffer[4096];
      pollfd waiting{client.get(), POLLIN, 0};
      if (::poll(&waiting, 1, 20) <= 0) return;
      const ssize_t n = ::recv(client.get(), buffer, sizeof buffer, 0);
      connected = n > 0;
      if (!connected) return;
      const std::string answer = service.feed({buffer, static_cast<std::size_t>(n)});
      ::usleep(1000);
      if (!answer.empty()) connected = ::send(client.get(), answer.data(), answer.size(), MSG_NOSIGNAL) > 0;
    };
    const Nanos give_up = now() + 60 * kNanosPerSecond;
    const auto pressed = [&] { return service.force != dvec3(0); };
    const Nanos moment = static_cast<Nanos>(random() % 40'000'000);
    for (Nanos since = 0; now() < give_up && connected;) {
      serve();
      if (pressed() && since == 0) since = now();
      if (pressed() && now() - since >= moment) break;
    }
    ASSERT_TRUE(connected && pressed()) << i;
    ::kill(child, i % 2 == 0 ? SIGKILL : SIGSTOP);
    while (now() < give_up && connected && pressed()) serve();
    EXPECT_FALSE(pressed()) << i;  // by a force of zero, not by a connection that broke
    service_priority.kill(child);
    while (now() < give_up && connected) serve();
    EXPECT_EQ(service.force, dvec3(0)) << i;
  }
}

}  // namespace
}  // namespace typodont::haptics
