// A program that presses with an arm and then ends in the way that its argument names. It writes one byte to standard
// output per force: 'F', or '0' for no force. Its servo runs until the end. The device's clock counts the samples, so a
// busy machine that stops the servo for some time does not end the force.
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>

#include "engine/base/check.h"
#include "haptics/device_safety.h"
#include "haptics/devices/safe_device.h"

namespace {

using namespace typodont;
using namespace typodont::haptics;

std::atomic<bool> pressing{false};  // true as soon as a force was sent

class PipeDevice : public HapticDevice {
 public:
  PipeDevice() { info_.force_limit = 5; }
  const DeviceInfo& info() const noexcept override { return info_; }
  bool read(HandSample& sample) noexcept override {
    ::usleep(1000);
    sample = {t_ += 1'000'000, {}, 0};
    return true;
  }
  void write(const dvec3& f, const dvec3&) noexcept override { send(f == dvec3(0) ? '0' : 'F'); }
  void release() noexcept override { send('0'); }

 private:
  void send(char c) noexcept {
    [[maybe_unused]] const auto n = ::write(1, &c, 1);
    if (c == 'F') pressing = true;
  }
  DeviceInfo info_;
  Nanos t_ = 0;
};

[[noreturn]] void throw_from_a_thread() {
  std::thread([] { throw 1; }).join();
  std::abort();
}

}  // namespace

int main(int argc, char** argv) {
  const std::string death = argc > 1 ? argv[1] : "";
  auto device = std::make_unique<PipeDevice>();
  auto options = SafeDevice::options_for(device->info());
  options.limits.silence = 10;  // the watchdog must not be what ends the force here
  // never destroyed, because its destructor must not end the force either
  auto* const hand = new SafeDevice(std::move(device), options);
  std::thread([hand] {
    HandSample sample;
    for (;;) {
      hand->read(sample);
      hand->write(hand->armed() ? dvec3(0, 0, 2) : dvec3(0), dvec3(0));
    }
  }).detach();
  for (int i = 0; i < 10'000 && !pressing; ++i) ::usleep(1000);
  ::usleep(20'000);
  if (death == "exit") std::exit(0);
  if (death == "quick_exit") std::quick_exit(0);
  if (death == "abort") std::abort();
  if (death == "segfault") ::raise(SIGSEGV);
  if (death == "exception") throw_from_a_thread();
  if (death == "check") {
    set_check_handler(release_all_devices);
    TYPODONT_CHECK(death.empty());
  }
  if (death == "term") ::kill(::getpid(), SIGTERM), ::sleep(5);
  if (death == "int") ::kill(::getpid(), SIGINT), ::sleep(5);
  if (death == "hup") ::kill(::getpid(), SIGHUP), ::sleep(5);
  if (death == "kill") ::kill(::getpid(), SIGKILL), ::sleep(5);
  ::_exit(99);
}
