// Opens again what was lost, on a thread of its own: the servo never waits for a device, and never allocates for one.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

namespace typodont::haptics {

/// Used by one thread (the servo): hand in the dead one with want(), ask take() for a new one until there is one.
template <class T>
class Reopener {
 public:
  /// `open` returns nothing, or throws, while the thing is not there; it is tried twice a second.
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

  /// Takes over the dead one: closing it may wait, so that happens on the thread. Never blocks, never allocates.
  void want(std::unique_ptr<T> dead) noexcept {
    delete dead_.exchange(dead.release());  // there is none: a second want() comes after a take()
    wanted_.store(true);
    wake_.notify_all();  // at worst unheard; then the thread looks by itself
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
      } catch (const std::exception&) {  // not there yet
      }
    }
  }

  std::function<std::unique_ptr<T>()> open_;
  std::chrono::milliseconds pause_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::atomic<T*> dead_{nullptr}, fresh_{nullptr};
  std::atomic<bool> wanted_{false}, ending_{false};
  std::thread thread_;  // the last member: it uses the others
};

}  // namespace typodont::haptics
