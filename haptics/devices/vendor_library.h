// A vendor's library, opened at run time when its owner has installed it; never linked, never shipped.
#pragma once

#include <initializer_list>
#include <string>

namespace typodont::haptics {

class VendorLibrary {
 public:
  /// Opens the first that is there. Throws Error that says what to install.
  VendorLibrary(std::initializer_list<const char*> names, const std::string& what_to_install);
  VendorLibrary(const VendorLibrary&) = delete;
  VendorLibrary& operator=(const VendorLibrary&) = delete;
  ~VendorLibrary();

  static bool present(std::initializer_list<const char*> names);

  /// Throws Error naming the library when it lacks the function.
  template <class F>
  void get(F*& function, const char* name) const {
    function = reinterpret_cast<F*>(symbol(name, true));
  }
  /// nullptr when it lacks it.
  template <class F>
  void find(F*& function, const char* name) const {
    function = reinterpret_cast<F*>(symbol(name, false));
  }

 private:
  void* symbol(const char* name, bool needed) const;
  void* handle_ = nullptr;
  std::string name_;
};

}  // namespace typodont::haptics
