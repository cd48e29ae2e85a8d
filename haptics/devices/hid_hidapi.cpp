#include <hidapi/hidapi.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <mutex>
#include <utility>

#include "engine/base/error.h"
#include "haptics/devices/fd_link.h"
#include "haptics/devices/hid.h"

namespace typodont::haptics {

namespace {

/// Converts a text for messages; characters beyond ASCII become '?'.
std::string narrow(const wchar_t* text) {
  std::string out;
  for (; text && *text; ++text) out += *text >= 32 && *text < 127 ? static_cast<char>(*text) : '?';
  return out;
}

// hidapi supports one thread at a time, but the threads that reopen a lost device call it, too.
std::mutex hidapi_mutex;

struct Closer {
  void operator()(hid_device* device) const { hid_close(device); }
};

class HidLink : public Link {
 public:
  HidLink(Descriptor own, hid_device* device) : own_(std::move(own)), device_(device) {}

  int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override {
    // hidapi waits whole milliseconds; remaining nanoseconds are slept here.
    const Nanos whole = timeout / 1'000'000, rest = timeout % 1'000'000;
    int n = hid_read_timeout(device_.get(), buffer.data(), buffer.size(), static_cast<int>(whole));
    if (n == 0 && rest > 0) {
      const timespec pause{0, rest};
      ::nanosleep(&pause, nullptr);
      n = hid_read_timeout(device_.get(), buffer.data(), buffer.size(), 0);
    }
    return n;
  }
  // Writes to a second descriptor, because hid_write() allocates; watchdog and signal handlers may call write().
  bool write(std::span<const std::uint8_t> bytes) noexcept override {
    const int kept = errno;
    const ssize_t n = ::write(own_.get(), bytes.data(), bytes.size());
    errno = kept;
    return n == static_cast<ssize_t>(bytes.size());
  }
  int descriptor() const noexcept override { return own_.get(); }

 private:
  Descriptor own_;
  std::unique_ptr<hid_device, Closer> device_;
};

}  // namespace

std::vector<HidNode> enumerate_hid() {
  const std::lock_guard lock(hidapi_mutex);
  std::vector<HidNode> nodes;
  hid_device_info* list = hid_enumerate(0, 0);
  for (const hid_device_info* d = list; d; d = d->next) {
    nodes.push_back({d->path ? d->path : "", d->vendor_id, d->product_id, d->usage_page, d->usage, d->interface_number,
                     narrow(d->manufacturer_string), narrow(d->product_string), narrow(d->serial_number)});
  }
  hid_free_enumeration(list);
  return nodes;
}

std::unique_ptr<Link> open_hid(const std::string& path) {
  const std::lock_guard lock(hidapi_mutex);
  Descriptor own = open_exclusively(path);
  hid_device* device = hid_open_path(path.c_str());
  if (!device) throw Error(path, "", narrow(hid_error(nullptr)), "a HID device");
  return std::make_unique<HidLink>(std::move(own), device);
}

}  // namespace typodont::haptics
