// Computes, for one renderer, the light that the bodies of a mouth reflect to each other, and the light inside their
// tissue. Render thread only.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "engine/app/surroundings/surroundings.h"
#include "engine/render/light_scene.h"
#include "engine/render/quality.h"
#include "engine/render/renderer.h"
#include "engine/render/tissue_light.h"

namespace typodont {

class MouthLight {
 public:
  /// When the light is computed. kInBackground: until it is finished, pictures are drawn without this light or with the
  /// last computed one.
  enum class When : std::uint8_t { kAtOnce, kInBackground };
  /// `around`: surroundings whose box `lit` is set; must not change while this object exists. `card`: name of the
  /// graphics card that computes the rays of the light; empty: the CPU computes them.
  MouthLight(const Surroundings& around, const render::Quality& quality,
             const std::array<render::Look, render::kMatterCount>& looks, When when, std::string card);
  ~MouthLight();
  MouthLight(const MouthLight&) = delete;
  MouthLight& operator=(const MouthLight&) = delete;

  /// Passes the working tooth's changed mesh bricks. `origin`: origin of their vertices, m, frame W.
  void put(std::span<const render::MeshUpdate> bricks, const dvec3& origin);
  /// Call before each frame. Adapts the light to changes of the lamps and to cuts of the working tooth. For the light
  /// between bodies, the tooth always has the shape that it had at the first call.
  void follow(const render::Lights& lights, render::Renderer& renderer);

 private:
  struct Put {
    std::vector<render::MeshUpdate> bricks;
    dvec3 origin;
  };
  void prepare();
  void compute(const std::optional<render::LightSources>& sources);
  bool start(const std::optional<render::LightSources>& sources);
  void hand_over(render::Renderer& renderer);

  const Surroundings& around_;
  const std::array<render::Look, render::kMatterCount> looks_;
  const render::Quality quality_;
  const When when_;
  const std::string card_;
  std::stop_source stop_;
  std::optional<render::Lights> lit_by_;
  std::vector<Put> waiting_;  // bricks that arrived since the last start of a computation
  // While the worker thread runs (from start() until `done_`), only it uses the next members.
  std::vector<Put> taken_;  // bricks for this computation
  std::optional<render::TissueLight> tissue_;
  std::optional<render::LightScene> bodies_;
  std::optional<render::LightGrid> grid_;  // new light between bodies
  render::CellBox changed_;                // cells inside tissue with new light; more cells may wait
  int refreshed_;                          // number of cells inside tissue that one computation after a cut takes
  std::exception_ptr failure_;
  std::atomic<bool> done_{false};
  std::jthread worker_;  // declared last, so that the thread is joined before the other members are destroyed
};

}  // namespace typodont
