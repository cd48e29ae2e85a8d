// The sliding and drilling tests of bench_models with CHAI3D's finger proxy (cAlgorithmFingerProxy, 3.3.0).
// CHAI3D gets the tissue in two forms: as the triangles of our fields, and as voxels (cVoxelObject). The radius of its
// proxy is the radius of the ball. Only voxels can be drilled. As in CHAI3D's example "28-voxel-basic", the voxel in
// contact becomes transparent, one in each tick. Prints the results as CSV.
#include <chai3d.h>
#include <fmt/format.h>

#include <vector>

#include "engine/base/units.h"
#include "haptics/tissue_mesh.h"
#include "peer.h"

namespace {

using namespace typodont;
using peers::Peer;
using peers::PeerTick;
using test::kProbeRadius;
using test::ModelTissue;

/// CHAI3D's tolerances assume numbers near one, so its world is in millimetres.
chai3d::cVector3d in_mm(const dvec3& p) {
  return {p.x / kMillimetre, p.y / kMillimetre, p.z / kMillimetre};
}

class FingerProxy : public Peer {
 public:
  PeerTick tick(const dvec3& hand, bool) override {
    return peers::timed_tick([&] { return computed(hand); });
  }
  double volume() const override { return 0; }

 protected:
  void begin(chai3d::cGenericObject* tissue, const dvec3& hand) {
    world_.addChild(tissue);  // the world deletes it
    tissue->setStiffness(peers::kStiffness * kMillimetre);
    world_.computeGlobalPositions(true);
    proxy_.initialize(&world_, in_mm(hand));
    proxy_.setProxyRadius(kProbeRadius / kMillimetre);
  }
  PeerTick computed(const dvec3& hand) {
    const chai3d::cVector3d f = proxy_.computeForces(in_mm(hand), chai3d::cVector3d(0, 0, 0));
    const chai3d::cVector3d p = proxy_.getProxyGlobalPosition();
    return {.force = {f.x(), f.y(), f.z()}, .ball = kMillimetre * dvec3(p.x(), p.y(), p.z())};
  }

  chai3d::cWorld world_;
  chai3d::cAlgorithmFingerProxy proxy_;
};

class Triangles : public FingerProxy {
 public:
  Triangles(const haptics::TissueMesh& surface, const dvec3& hand) {
    auto* mesh = new chai3d::cMesh;
    for (const dvec3& v : surface.vertices) mesh->newVertex(in_mm(v));
    for (const auto& t : surface.triangles) mesh->newTriangle(t[0], t[1], t[2]);
    mesh->setUseCulling(false);
    mesh->createAABBCollisionDetector(kProbeRadius / kMillimetre);
    begin(mesh, hand);
  }
};

class Voxels : public FingerProxy {
 public:
  Voxels(const haptics::TissueVolume& tissue, const dvec3& hand) : voxel_(tissue.frame().voxel), last_(hand) {
    glm::ivec3 lo, hi;
    tissue.bounds(lo, hi);
    const glm::ivec3 size = hi - lo + 1;
    std::vector<float> distance(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                                static_cast<std::size_t>(size.z));
    tissue.copy(lo, size, distance.data(), nullptr);
    image_->allocate(static_cast<unsigned>(size.x), static_cast<unsigned>(size.y), static_cast<unsigned>(size.z),
                     GL_RGBA);
    std::size_t i = 0;
    for (int x = 0; x < size.x; ++x)
      for (int y = 0; y < size.y; ++y)
        for (int z = 0; z < size.z; ++z) set({x, y, z}, distance[i++] < 0);
    const auto texture = chai3d::cTexture3d::create();
    texture->setImage(image_);
    object_->setTexture(texture);
    object_->m_minCorner = in_mm(tissue.frame().to_world(dvec3(lo) - 0.5));
    object_->m_maxCorner = in_mm(tissue.frame().to_world(dvec3(hi) + 0.5));
    object_->m_minTextureCoord.set(0, 0, 0);
    object_->m_maxTextureCoord.set(1, 1, 1);
    begin(object_, hand);
  }

  PeerTick tick(const dvec3& hand, bool drills) override {
    return peers::timed_tick([&] {
      PeerTick tick = computed(hand);
      if (drills && proxy_.getNumCollisionEvents() > 0) {
        const chai3d::cCollisionEvent& touched = *proxy_.m_collisionEvents[0];
        set({touched.m_voxelIndexX, touched.m_voxelIndexY, touched.m_voxelIndexZ}, false);
        tick.cut = std::pair(last_, tick.ball);
      }
      last_ = tick.ball;
      return tick;
    });
  }

  double volume() const override { return static_cast<double>(solid_) * voxel_ * voxel_ * voxel_; }

 private:
  void set(const glm::ivec3& at, bool solid) {
    const auto x = static_cast<unsigned>(at.x), y = static_cast<unsigned>(at.y), z = static_cast<unsigned>(at.z);
    chai3d::cColorb color;
    if (image_->getVoxelColor(x, y, z, color) && color.getA() > 0) --solid_;
    image_->setVoxelColor(x, y, z, solid ? chai3d::cColorb(255, 255, 255, 255) : chai3d::cColorb(0, 0, 0, 0));
    if (solid) ++solid_;
  }

  double voxel_;  // m
  dvec3 last_;    // m, position of the ball in the last tick
  long solid_ = 0;
  chai3d::cMultiImagePtr image_ = chai3d::cMultiImage::create();
  chai3d::cVoxelObject* object_ = new chai3d::cVoxelObject;
};

}  // namespace

int main() {
  peers::print_header();
  for (const ModelTissue& tissue : test::analytic_tissues()) {
    const test::Course course = peers::slide_course(tissue);
    for (const double voxel_mm : {0.2, 0.1, 0.05}) {
      const haptics::TissueVolume volume = tissue.make(voxel_mm);
      const haptics::TissueMesh surface = haptics::surface_mesh(volume);
      const std::string knob = fmt::format("voxel {:g} mm", voxel_mm);
      const peers::PeerModel triangles{"CHAI3D finger proxy", knob, [&](const dvec3& hand, bool) {
                                         return std::make_unique<Triangles>(surface, hand);
                                       }};
      const peers::PeerModel voxels{"CHAI3D voxels", knob,
                                    [&](const dvec3& hand, bool) { return std::make_unique<Voxels>(volume, hand); }};
      const peers::PeerModel ours = peers::default_model(tissue, voxel_mm);
      for (const peers::PeerModel* model : {&triangles, &voxels, &ours}) peers::print_slide(tissue, course, *model);
      if (!tissue.solid) continue;
      for (const peers::PeerModel* model : {&voxels, &ours}) peers::print_drill(tissue, *model);
    }
  }
}
