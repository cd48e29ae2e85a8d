// Lists devices that need a vendor's library. These devices identify themselves only while they are open. So each
// device is opened briefly, one after the other, and its description is cached. None is opened while this process
// uses a device of the same library; that device reports its own description.
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
  /// `plain`: the data known without opening. `ask` opens device i, describes it and closes it again. If `ask` fails,
  /// the entry says that access is not permitted, and the next call tries again. Throws what `ask` throws.
  std::vector<FoundDevice> list(std::vector<FoundDevice> plain, const std::function<FoundDevice(std::size_t)>& ask);

  /// Exists while a device of the library is open in this process.
  class Use {
   public:
    explicit Use(VendorDevices& devices);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    /// Stores the description that the device gave when it was opened.
    void is(const FoundDevice& device);

   private:
    VendorDevices& devices_;
  };

 private:
  std::mutex mutex_;
  int in_use_ = 0;
  // number of devices at the last search; if it changes, addresses may refer to other devices
  std::size_t plugged_in_ = 0;
  std::map<std::string, FoundDevice> known_;  // descriptions of the known devices, by address
};

}  // namespace typodont::haptics
