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
// Number of cells inside tissue whose light one computation after a cut takes. With a graphics card, a live session
// computes as many as it can in kRefreshTime, but not fewer.
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
    : around_(around), looks_(looks), quality_(quality), when_(when), card_(std::move(card)), refreshed_(kRefreshed) {}

MouthLight::~MouthLight() {
  stop_.request_stop();
}

void MouthLight::put(std::span<const render::MeshUpdate> bricks, const dvec3& origin) {
  waiting_.push_back({{bricks.begin(), bricks.end()}, origin});
}

/// Makes the bodies that the light meets.
void MouthLight::prepare() {
  const render::Quality& inside = of_tissue(quality_, when_, card_);
  tissue_.emplace(*around_.lit, inside.light_cell, inside.light_walks, looks_, stop_.get_token());
  std::vector<render::LitTriangle> triangles;
  for (const Put& put : taken_) render::append_triangles(triangles, put.bricks, put.origin, looks_);
  for (const SurroundingMesh& mesh : around_.meshes) {
    std::vector<render::LitTriangle> body;
    render::append_triangles(body, mesh.bricks, mesh.origin, looks_);
    triangles.insert(triangles.end(), body.begin(), body.end());
    const bool empty = mesh.bricks.empty() || mesh.bricks.front().vertices.empty();
    const Tissue outer = empty ? Tissue::kAir : mesh.bricks.front().vertices.front().tissue[0];
    const bool hard = outer == Tissue::kEnamel || outer == Tissue::kDentin || outer == render::kPlastic;
    tissue_->add_fixed(std::move(body), hard);
  }
  const std::shared_ptr passes = card_.empty() ? nullptr : render::LightPasses::make(card_);
  tissue_->use(passes);
  bodies_.emplace(std::move(triangles), *around_.lit, kSpacing, quality_.tissue_mirrors, stop_.get_token(), passes);
}

/// Computes the light of new sources, or else the light of some cells near cuts.
void MouthLight::compute(const std::optional<render::LightSources>& sources) {
  if (!bodies_) prepare();
  for (const Put& put : std::exchange(taken_, {})) tissue_->put(put.bricks, put.origin);
  changed_ = {};
  if (sources) return tissue_->light(*sources, grid_.emplace(bodies_->light(*sources)));
  const Nanos begin = now();
  changed_ = tissue_->refresh(refreshed_);
  if (tissue_->on_card() && when_ == When::kInBackground && !changed_.empty())
    refreshed_ = std::clamp(now() - begin < kRefreshTime ? 2 * refreshed_ : refreshed_ / 2, kRefreshed, kMaxRefreshed);
}

/// Starts the worker thread. False: the system grants no thread.
bool MouthLight::start(const std::optional<render::LightSources>& sources) {
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
  if (grid_)
    renderer.set_light(*grid_, tissue_->grid());
  else if (!changed_.empty())
    renderer.update_tissue_light(tissue_->grid().values, changed_);
  grid_.reset();
}

void MouthLight::follow(const render::Lights& lights, render::Renderer& renderer) {
  if (worker_.joinable()) {
    if (!done_.load(std::memory_order_acquire)) return;
    worker_.join();
    hand_over(renderer);
  }
  std::optional<render::LightSources> sources;
  if (!lit_by_ || !same_light(lights, *lit_by_)) {
    lit_by_ = lights;
    sources = render::sources_of(lights);
  }
  if (!sources && waiting_.empty() && changed_.empty()) return;
  taken_ = std::exchange(waiting_, {});
  if (when_ == When::kInBackground && start(sources)) return;
  compute(sources);
  hand_over(renderer);
}

}  // namespace typodont
