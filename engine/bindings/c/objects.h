// The objects to which the handles of scenes, hands and cores refer.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/offline.h"
#include "engine/app/scene.h"
#include "engine/app/wiring.h"
#include "engine/base/latest.h"
#include "engine/base/ring.h"
#include "engine/bindings/c/call.h"
#include "engine/surface/surface_mesher.h"
#include "haptics/lockstep.h"
#include "haptics/patch_exchange.h"

namespace typodont::bindings {

struct SceneObject {
  Scene scene;
  std::vector<std::string> tools = tool_names(scene);
  std::string model{model_name(scene)};
};

struct HandObject {
  std::unique_ptr<haptics::HapticDevice> device;
};

/// The channels between the servo's thread and the core's thread. Each channel has one writer and one reader.
struct Channels {
  explicit Channels(const haptics::Carver& carver) : patch(carver) {}
  // The servo writes these channels, and the core reads them.
  Ring<Cut> cuts{1 << 14};
  Latest<ServoTick> tick;
  // The servo writes these channels for the recording. A tick contains the number of its patch (copy of the tissue) and
  // of its last cut. So the servo sends the use of a patch, and a cut, before the tick that contains their numbers.
  Ring<PatchUse> recorded_patches{1 << 12};
  Ring<Cut> recorded_cuts{1 << 14};
  Ring<ServoTick> recorded_ticks{1 << 15};
  // The core writes this channel, and the servo reads it.
  haptics::PatchExchange patch;
};

struct CoreObject {
  CoreObject(Scene s, haptics::DeviceInfo h);
  ~CoreObject();
  CoreObject(const CoreObject&) = delete;
  CoreObject& operator=(const CoreObject&) = delete;

  Scene scene;
  haptics::DeviceInfo hand;
  std::uint32_t tools;
  /// Data that the core shares with a servo on another thread. The servo's thread uses the class Servo, and the core's
  /// thread uses the class Carver.
  struct Shared {
    haptics::LockStep steps;
    std::unique_ptr<Channels> channels;  // null while the servo runs on the core's thread
    bool records = false;  // true if the servo's data is recorded; set before the servo moves to another thread
  };
  std::shared_ptr<Shared> shared;
  std::uint64_t ticks = 0;  // number of ticks that step() has computed
  // Every tick uses `recording` and the members below it. They are next to each other in memory, so that the cache
  // loads them together.
  std::optional<OfflineRecording> recording;
  ServoTick tick;  // the latest tick
  Cut cut;
  // The next patch use (patch: copy of the tissue) and the next cut from the servo's queues. They wait here until the
  // recording has reached the tick that contains their numbers.
  std::optional<PatchUse> next_patch;
  std::optional<Cut> next_cut;

  // Converts the tissue's surface to triangles. This member and the following ones belong to the surface mesh.
  surface::SurfaceMesher mesher;
  bool meshed = false;
  std::vector<std::vector<typodont_vertex>> vertices;  // vertices of each element of `parts`
  std::vector<typodont_mesh_part> parts;

  haptics::Carver& carver() { return shared->steps.carver(); }
  haptics::TissueVolume& volume() { return carver().volume(); }
  /// Computes one tick of servo and carver together on this thread, and records it if a recording exists. Returns true
  /// if the tick removed tissue.
  bool step(const haptics::HandSample& sample);
};

struct ServoObject {
  std::shared_ptr<CoreObject::Shared> shared;
  std::uint32_t tools;
  std::uint64_t ticks = 0;
  ServoTick tick;
  Cut cut;
};

}  // namespace typodont::bindings
