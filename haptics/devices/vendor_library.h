// A vendor's library: loaded at run time if it is installed, never linked or shipped. Also the devices that it finds.
#pragma once

#include <functional>
#include <initializer_list>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "haptics/devices.h"

namespace typodont::haptics {

class VendorLibrary {
 public:
  /// Loads the first of `names` that exists. Otherwise throws Error that says what to install.
  VendorLibrary(std::initializer_list<const char*> names, const std::string& what_to_install);
  VendorLibrary(const VendorLibrary&) = delete;
  VendorLibrary& operator=(const VendorLibrary&) = delete;
  ~VendorLibrary();

  static bool present(std::initializer_list<const char*> names);

  /// Returns a function of the library. Throws an Error that names the library if it does not have the function.
  template <class F>
  void get(F*& function, const char* name) const {
    function = reinterpret_cast<F*>(symbol(name, true));
  }
  /// Returns a function of the library, or nullptr if the library does not have it.
  template <class F>
  void find(F*& function, const char* name) const {
    function = reinterpret_cast<F*>(symbol(name, false));
  }

 private:
  void* symbol(const char* name, bool needed) const;
  void* handle_ = nullptr;
  std::string name_;
};

/// Descriptions of the devices that a vendor's library finds. The library describes only open devices, so each device
/// is opened briefly. While one is in use, no other is opened, and Use::is() describes the one in use.
class VendorDevices {
 public:
  /// Lists the devices. `plain`: what is known without opening. `ask` opens device i, describes it and closes it. If
  /// the device cannot be opened, the next call asks again; exceptions of `ask` are passed on.
  std::vector<FoundDevice> list(std::vector<FoundDevice> plain, const std::function<FoundDevice(std::size_t)>& ask);

  /// Exists while this process has a device open.
  class Use {
   public:
    explicit Use(VendorDevices& devices);
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    /// Stores the description that the device reported when opened.
    void is(const FoundDevice& device);

   private:
    VendorDevices& devices_;
  };

 private:
  std::mutex mutex_;
  int in_use_ = 0;
  // Number of devices at the last search; if it changes, the descriptions are invalid.
  std::size_t plugged_in_ = 0;
  std::map<std::string, FoundDevice> known_;  // descriptions of the known devices by address
};

}  // namespace typodont::haptics
