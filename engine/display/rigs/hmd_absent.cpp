// Replacement for hmd.cpp in a build without OpenXR.
#include "engine/base/error.h"
#include "engine/display/hmd.h"

namespace typodont::display {

std::unique_ptr<Hmd> Hmd::open(const DisplayRig&, RuntimeGate&) {
  throw Error("this build", "", "no OpenXR", "a build with TYPODONT_OPENXR=ON, or another rig");
}

}  // namespace typodont::display
