#include "haptics/bench/scene.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <cmath>
#include <string>
#include <utility>

#include "engine/base/units.h"

namespace typodont::haptics::bench {

DenseTissue tissue(std::string_view solids, double voxel_mm) {
  return read_solids(Json::parse(fmt::format(R"({{"voxel_mm": {:g}, "solids": {}}})", voxel_mm, solids), "bench"));
}

Tool head(HeadShape shape, double diameter, double length) {
  Tool tool;
  tool.shape = shape;
  tool.diameter = diameter;
  tool.length = length;
  return tool;
}

double degrees_between(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / kPi;
}

OtherThread::OtherThread() : thread_([this] { loop(); }) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  pthread_getaffinity_np(pthread_self(), sizeof cores, &cores);
  const int here = sched_getcpu();
  if (CPU_COUNT(&cores) < 2 || here < 0) return;
  CPU_CLR(here, &cores);
  pthread_setaffinity_np(thread_.native_handle(), sizeof cores, &cores);
}

OtherThread::~OtherThread() {
  work_ = nullptr;
  hand_over();
  thread_.join();
}

void OtherThread::run(std::function<void()> work) {
  work_ = std::move(work);
  hand_over();
  busy_.wait(true, std::memory_order_acquire);
}

void OtherThread::hand_over() {
  busy_.store(true, std::memory_order_release);
  busy_.notify_one();
}

void OtherThread::loop() {
  for (;;) {
    busy_.wait(false, std::memory_order_acquire);
    if (!work_) return;
    work_();
    busy_.store(false, std::memory_order_release);
    busy_.notify_one();
  }
}

static ServoSettings with_materials(ServoSettings s) {
  for (Material& material : s.materials) material = {1000, 8e9, 0.2, 0.15, 2150, dvec3(0.8)};
  return s;
}

Scene::Scene(const DenseTissue& dense, const ServoSettings& s) : Scene(TissueVolume(dense), s) {}

Scene::Scene(TissueVolume tissue, const ServoSettings& s) : steps(std::move(tissue), with_materials(s)) {}

bool Scene::renew_patch(const Pose& X_WT) {
  if (t == 0) last.X_WT = last.X_WG = X_WT;
  if (!carver.snapshot_due(last)) return false;
  carving.run([&] { steps.take_snapshot(carver.snapshot_center(last)); });
  steps.adopt_snapshot();
  return true;
}

double Scene::tick(const Pose& X_WT, double pedal) {
  renew_patch(X_WT);
  steps.tick_servo({t, X_WT, pedal}, last, cut);
  steps.apply_cuts(last.cuts);
  t += from_seconds(settings.tick);
  return static_cast<double>(last.cpu_time);
}

}  // namespace typodont::haptics::bench
