// The objects behind the handles of scenes, hands and cores.
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

/// The channels between the servo's thread and the core's thread. Each has one writer and one reader.
struct Channels {
  explicit Channels(const haptics::Carver& carver) : patch(carver) {}
  // Channel from servo to core.
  Ring<Cut> cuts{1 << 14};
  Latest<ServoTick> tick;
  // Channels from servo to core, for recording. Patches and cuts are pushed before the ticks that name them.
  Ring<PatchUse> recorded_patches{1 << 12};
  Ring<Cut> recorded_cuts{1 << 14};
  Ring<ServoTick> recorded_ticks{1 << 15};
  // Channel from core to servo.
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
  /// Data that the core shares with a servo on another thread: the servo's thread uses Servo, the core's thread uses
  /// Carver.
  struct Shared {
    haptics::LockStep steps;
    std::unique_ptr<Channels> channels;  // null while the servo runs on the core's thread
    bool records = false;                // set before the servo moves to another thread
  };
  std::shared_ptr<Shared> shared;
  std::uint64_t ticks = 0;                    // number of ticks on this thread
  std::optional<OfflineRecording> recording;  // beside the data that every tick reads, for the cache
  ServoTick tick;                             // the latest tick
  Cut cut;
  // The next patch and the next cuts from the servo's rings. They wait here until the tick that names them is
  // recorded.
  std::optional<PatchUse> next_patch;
  std::optional<Cut> next_cut;

  // Members for the surface mesh.
  surface::SurfaceMesher mesher;
  bool meshed = false;
  std::vector<std::vector<typodont_vertex>> vertices;  // vertices of `parts`
  std::vector<typodont_mesh_part> parts;

  haptics::Carver& carver() { return shared->steps.carver(); }
  haptics::TissueVolume& volume() { return carver().volume(); }
  /// Computes one tick in lock-step, and records it if requested. Returns true if the tick cut.
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
