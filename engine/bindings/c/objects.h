// The objects to which the handles of scenes, hands and cores refer.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/app/recording.h"
#include "engine/app/scene.h"
#include "engine/app/session_start.h"
#include "engine/app/sides.h"
#include "engine/bindings/c/call.h"
#include "engine/surface/surface_mesher.h"
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
    SteppedSession session;
    std::unique_ptr<haptics::PatchExchange> patch;  // null while servo and carver run on the same thread
  };
  std::shared_ptr<Shared> shared;
  bool begun = false;  // true after step() has computed a tick
  std::optional<SessionRecorder> recording;
  std::optional<CarverSide> side;  // empty while servo and carver run on the same thread

  // Converts the tissue's surface to triangles. This member and the following ones belong to the surface mesh.
  surface::SurfaceMesher mesher;
  bool meshed = false;
  std::vector<std::vector<typodont_vertex>> vertices;  // vertices of each element of `parts`
  std::vector<typodont_mesh_part> parts;

  haptics::Carver& carver() { return shared->session.carver(); }
  haptics::TissueVolume& volume() { return carver().volume(); }
  /// Computes one tick of servo and carver together on this thread, and records it if a recording exists.
  SteppedSession& step(const haptics::HandSample& sample);
  /// Writes new events to the recording, if one exists.
  void record();
};

struct ServoObject {
  std::shared_ptr<CoreObject::Shared> shared;
  ServoSide side;
  std::uint32_t tools;
  ServoTick tick;
  Cut cut;
};

}  // namespace typodont::bindings
