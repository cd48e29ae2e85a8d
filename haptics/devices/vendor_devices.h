// Devices behind a vendor's library say who they are only while they are open. For a list they are opened for a moment,
// one after the other, and remembered; never while this process works with a device of the same library, which then
// knows itself.
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
  /// `plain`: what is known without opening. `ask` opens the i-th of them, describes it and closes it again; where that
  /// fails it says that it is not permitted, and is asked again next time. Throws what `ask` throws.
  std::vector<FoundDevice> list(std::vector<FoundDevice> plain, const std::function<FoundDevice(std::size_t)>& ask);

  /// While this lives, a device of the library is open here.
  class Use {
   public:
    explicit Use(VendorDevices& devices);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    /// What it said when it was opened.
    void is(const FoundDevice& device);

   private:
    VendorDevices& devices_;
  };

 private:
  std::mutex mutex_;
  int in_use_ = 0;
  std::size_t plugged_in_ = 0;                // at the last look: another number, and the addresses may mean others
  std::map<std::string, FoundDevice> known_;  // by address
};

}  // namespace typodont::haptics
