#include "engine/base/late_library.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include "engine/base/error.h"

namespace typodont {

namespace {
// Written only while the program, or a shared library with this code, starts.
constinit LateLibrary* first_library = nullptr;
}  // namespace

LateSymbol::LateSymbol(LateLibrary& library, const char* name)
    : library_(library), name_(name), next_(library.symbols_) {
  if (!library.symbols_) {
    library.next_ = first_library;
    first_library = &library;
  }
  library.symbols_ = this;
}

void* LateSymbol::load() const {
  library_.load();
  return address_.load(std::memory_order_acquire);
}

std::vector<LateLibrary*> LateLibrary::all() {
  std::vector<LateLibrary*> found;
  for (LateLibrary* library = first_library; library; library = library->next_) found.push_back(library);
  return found;
}

void LateLibrary::load() {
  const std::lock_guard lock(loading_);
  void* const opened = ::dlopen(find_ ? find_().c_str() : file_, RTLD_NOW | RTLD_LOCAL);
  const auto fail = [&] {
    throw Error(file_, "", ::dlerror(), fmt::format("an installed library: sudo apt install {}", package_));
  };
  if (!opened) fail();
  for (LateSymbol* symbol = symbols_; symbol; symbol = symbol->next_) {
    void* const address = ::dlsym(opened, symbol->name_);
    if (!address) fail();
    symbol->address_.store(address, std::memory_order_release);
  }
}

}  // namespace typodont
