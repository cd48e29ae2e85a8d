#include "engine/app/picture/mouth_light.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <system_error>
#include <utility>

#include "engine/base/clock.h"
#include "engine/base/in_parallel.h"
#include "engine/base/realtime.h"
#include "engine/base/units.h"
#include "engine/render/light_passes.h"

namespace typodont {

namespace {

constexpr double kSpacing = 1.25e-3;  // m, grid spacing of the light between bodies
// Number of cells inside tissue whose light is computed again per frame. With a graphics card, a live session computes
// as many as it can in kRefreshTime, but not fewer.
constexpr int kRefreshed = 40, kMaxRefreshed = 1024;
constexpr Nanos kRefreshTime = kNanosPerSecond / 250;

/// True if the lights have the same strength, and the same directions within 0.5°.
bool same_light(const render::Lights& a, const render::Lights& b) {
  const double near = std::cos(0.5 * kDegree);
  const auto close = [&](const dvec3& p, const dvec3& q) {
    return glm::dot(glm::normalize(p), glm::normalize(q)) > near;
  };
  return close(a.key, b.key) && close(a.up, b.up) && close(toward_window(a), toward_window(b)) &&
         a.key_strength == b.key_strength && a.ambient == b.ambient;
}

/// Quality of the light inside tissue. A live session begins below the best level, and a card has time for it.
const render::Quality& of_tissue(const render::Quality& quality, MouthLight::When when, const std::string& card) {
  return when == MouthLight::When::kInBackground && !card.empty() ? render::kQualityLadder.front() : quality;
}

}  // namespace

MouthLight::MouthLight(const Surroundings& around, const render::Quality& quality,
                       const std::array<render::Look, render::kMatterCount>& looks, When when, std::string card)
    : around_(around),
      looks_(looks),
      tissue_mirrors_(quality.tissue_mirrors),
      when_(when),
      card_(std::move(card)),
      refreshed_(kRefreshed),
      tissue_(*around.lit, of_tissue(quality, when, card_).light_cell, of_tissue(quality, when, card_).light_walks,
              looks, stop_.get_token()) {}

MouthLight::~MouthLight() {
  stop_.request_stop();
}

void MouthLight::put(std::span<const render::MeshUpdate> bricks, const dvec3& origin) {
  if (!tooth_known_) render::append_triangles(tooth_, bricks, origin, looks_);
  if (worker_.joinable())
    waiting_.push_back({{bricks.begin(), bricks.end()}, origin});
  else
    tissue_.put(bricks, origin);
}

void MouthLight::compute(const render::LightSources& sources) {
  if (!bodies_) {
    std::vector<render::LitTriangle> triangles = std::move(tooth_);
    for (const SurroundingMesh& mesh : around_.meshes) {
      std::vector<render::LitTriangle> body;
      render::append_triangles(body, mesh.bricks, mesh.origin, looks_);
      triangles.insert(triangles.end(), body.begin(), body.end());
      const bool empty = mesh.bricks.empty() || mesh.bricks.front().vertices.empty();
      const Tissue outer = empty ? Tissue::kAir : mesh.bricks.front().vertices.front().tissue[0];
      const bool hard = outer == Tissue::kEnamel || outer == Tissue::kDentin || outer == render::kPlastic;
      tissue_.add_fixed(std::move(body), hard);
    }
    const std::shared_ptr passes = card_.empty() ? nullptr : render::LightPasses::make(card_);
    tissue_.use(passes);
    bodies_.emplace(std::move(triangles), *around_.lit, kSpacing, tissue_mirrors_, stop_.get_token(), passes);
  }
  grid_ = bodies_->light(sources);
  tissue_.light(sources, grid_);
}

/// Starts the worker thread. False: the system grants no thread.
bool MouthLight::start(const render::LightSources& sources) {
  done_ = false;
  const auto work = [this, sources] {
    lower_priority();
    try {
      compute(sources);
    } catch (const Stopped&) {
    } catch (...) {
      failure_ = std::current_exception();
    }
    done_.store(true, std::memory_order_release);
  };
  try {
    worker_ = std::jthread(work);
  } catch (const std::system_error&) {
    return false;
  }
  return true;
}

void MouthLight::hand_over(render::Renderer& renderer) {
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  renderer.set_light(grid_, tissue_.grid());
  grid_ = {};
  for (const Put& put : std::exchange(waiting_, {})) tissue_.put(put.bricks, put.origin);
}

void MouthLight::follow(const render::Lights& lights, render::Renderer& renderer) {
  tooth_known_ = true;
  if (worker_.joinable()) {
    if (!done_.load(std::memory_order_acquire)) return;
    worker_.join();
    hand_over(renderer);
  }
  if (lit_by_ && same_light(lights, *lit_by_)) {
    const Nanos begin = now();
    const render::CellBox changed = tissue_.refresh(refreshed_);
    if (changed.empty()) return;
    renderer.update_tissue_light(tissue_.grid().values, changed);
    if (tissue_.on_card() && when_ == When::kInBackground)
      refreshed_ =
          std::clamp(now() - begin < kRefreshTime ? 2 * refreshed_ : refreshed_ / 2, kRefreshed, kMaxRefreshed);
    return;
  }
  lit_by_ = lights;
  const render::LightSources sources = render::sources_of(lights);
  if (when_ == When::kInBackground && start(sources)) return;
  compute(sources);
  hand_over(renderer);
}

}  // namespace typodont
