// Reopens a lost device on a separate thread, because the servo must not wait or allocate.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace typodont::haptics {

/// Used by one thread: it passes the lost object to want(), then calls take() until a new object is there.
template <class T>
class Reopener {
 public:
  /// `open` returns null or throws while the device is missing; it is called twice per second.
  explicit Reopener(std::function<std::unique_ptr<T>()> open,
                    std::chrono::milliseconds pause = std::chrono::milliseconds(500))
      : open_(std::move(open)), pause_(pause), thread_([this] { work(); }) {}
  ~Reopener() {
    ending_.store(true);
    { const std::lock_guard lock(mutex_); }
    wake_.notify_all();
    thread_.join();
    delete dead_.load();
    delete fresh_.load();
  }
  Reopener(const Reopener&) = delete;
  Reopener& operator=(const Reopener&) = delete;

  /// Passes the lost object to the reopening thread, which closes it, because closing may block. Never blocks or
  /// allocates.
  void want(std::unique_ptr<T> dead) noexcept {
    // `dead_` is normally empty, because take() was called before.
    delete dead_.exchange(dead.release());
    wanted_.store(true);
    wake_.notify_all();  // even if the thread misses this notification, it checks regularly
  }
  std::unique_ptr<T> take() noexcept { return std::unique_ptr<T>(fresh_.exchange(nullptr)); }

 private:
  void work() {
    std::unique_lock lock(mutex_);
    while (!ending_.load()) {
      wake_.wait_for(lock, pause_, [this] { return ending_.load() || dead_.load() != nullptr; });
      delete dead_.exchange(nullptr);
      if (ending_.load() || !wanted_.load()) continue;
      try {
        std::unique_ptr<T> fresh = open_();
        if (!fresh) continue;
        wanted_.store(false);
        delete fresh_.exchange(fresh.release());
      } catch (const std::exception&) {  // the device is still missing; the next attempt follows later
      }
    }
  }

  std::function<std::unique_ptr<T>()> open_;
  std::chrono::milliseconds pause_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<T*> dead_{nullptr}, fresh_{nullptr};
  std::atomic<bool> wanted_{false}, ending_{false};
  std::thread thread_;  // declared last, because the thread uses the other members
};

}  // namespace typodont::haptics
