// The interface between an OpenXR loader and a runtime, from the loader's specification (no Debian package contains
// this header).
#pragma once

#include <openxr/openxr.h>

#include <cstddef>
#include <cstdint>

namespace typodont::test::xr {

constexpr std::uint32_t kLoaderInfo = 1, kRuntimeRequest = 3, kInterfaceVersion = 1;

struct LoaderInfo {
  std::uint32_t type, version;
  std::size_t size;
  std::uint32_t min_interface, max_interface;
  XrVersion min_api, max_api;
};

struct RuntimeRequest {
  std::uint32_t type, version;
  std::size_t size;
  std::uint32_t interface;
  XrVersion api;
  PFN_xrGetInstanceProcAddr get_instance_proc_addr;
};

}  // namespace typodont::test::xr
