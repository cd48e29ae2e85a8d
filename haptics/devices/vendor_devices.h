// Devices of a vendor's library, described only while open: each is opened briefly, never beside one in use, which
// describes itself.
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
  /// `plain`: known without opening; `ask` opens device i, describes and closes it; a failure is asked again next time;
  /// exceptions pass.
  std::vector<FoundDevice> list(std::vector<FoundDevice> plain, const std::function<FoundDevice(std::size_t)>& ask);

  /// While this process has one open.
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
  // at the last search; a change makes descriptions invalid
  std::size_t plugged_in_ = 0;
  std::map<std::string, FoundDevice> known_;  // descriptions of the known devices by address
};

}  // namespace typodont::haptics
