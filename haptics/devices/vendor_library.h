// A vendor's library that is loaded at run time if it is installed; never linked or shipped.
#pragma once

#include <initializer_list>
#include <string>

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

}  // namespace typodont::haptics
