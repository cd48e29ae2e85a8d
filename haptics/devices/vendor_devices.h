// Lists devices that need the library of a vendor. Such a device can be described only while it is open. So each device
// is opened briefly, one after the other, and its description is stored. While this process uses a device of a library,
// no device of this library is opened; the device in use reports its own description.
#pragma once

#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "haptics/devices.h"

namespace typodont::haptics {

class VendorDevices {
 public:
  /// Returns the list. `plain` contains what is known about each device without opening it. `ask` opens device i,
  /// describes it and closes it again. If the result of `ask` states a failure, the list states for this device that
  /// access is not permitted, and the next call of list() asks again. If `ask` throws an exception, so does list().
  std::vector<FoundDevice> list(std::vector<FoundDevice> plain, const std::function<FoundDevice(std::size_t)>& ask);

  /// An object of this class exists while this process has a device of the library open.
  class Use {
   public:
    explicit Use(VendorDevices& devices);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    /// Stores the description that the device reported when it was opened.
    void is(const FoundDevice& device);

   private:
    VendorDevices& devices_;
  };

 private:
  std::mutex mutex_;
  int in_use_ = 0;
  // Number of devices at the last search. If the number has changed, an address may now belong to another device, so
  // the stored descriptions are not valid any more.
  std::size_t plugged_in_ = 0;
  std::map<std::string, FoundDevice> known_;  // descriptions of the known devices by address
};

}  // namespace typodont::haptics
