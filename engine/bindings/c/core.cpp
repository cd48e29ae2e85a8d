// The functions of the C interface for the haptic core: ticks, the tissue and recordings.
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "engine/base/clock.h"
#include "engine/bindings/c/objects.h"
#include "engine/contract/session_length.h"

namespace typodont::bindings {

namespace {

constexpr const char* kSampleAndTick = "sample, tick or cut: NULL, or struct_size is not that of the struct";
constexpr const char* kBadPose =
    "a pose or a pedal that is not a number, too far away, or no unit quaternion, or a time that runs backwards or is "
    "more than a day: no force";
constexpr const char* kNoSuchTool = "sample.tool: the scene's tray has no such place";
constexpr const char* kGivenAway = "the servo was given away: use typodont_servo_tick and typodont_core_carve";

/// Sets the processor's modes for rounding and denormals, and restores the previous modes at the end of the scope.
/// Hosts such as games change these modes, but equal hand samples must give bit-identical results in every host.
class IeeeArithmetic {
 public:
#ifdef __SSE2__
  // bits of the control register MXCSR: flush to zero, rounding mode, denormals are zero
  static constexpr unsigned kFlushAndRound = 0xE040;
  IeeeArithmetic() noexcept : was_(_mm_getcsr()) {
    if (was_ & kFlushAndRound) _mm_setcsr(was_ & ~kFlushAndRound);
  }
  ~IeeeArithmetic() {
    if (was_ & kFlushAndRound) _mm_setcsr(was_);
  }
#else
  IeeeArithmetic() noexcept {}
  ~IeeeArithmetic() {}
#endif
  IeeeArithmetic(const IeeeArithmetic&) = delete;
  IeeeArithmetic& operator=(const IeeeArithmetic&) = delete;

 private:
#ifdef __SSE2__
  unsigned was_;
#endif
};

bool usable(const typodont_sample* sample, const typodont_tick* out, const typodont_cut* cut) noexcept {
  return sample && out && sized(sample->struct_size, sizeof *sample) && sized(out->struct_size, sizeof *out) &&
         (!cut || sized(cut->struct_size, sizeof *cut));
}

/// Loads the host's struct `out` into the cache while the tick is computed. Without this, the call would take longer,
/// because writing the result would wait for memory.
void prefetch(typodont_tick& out) noexcept {
  constexpr std::size_t kLine = 64;  // bytes, length of a cache line
  for (std::size_t at = 0; at < sizeof out; at += kLine) __builtin_prefetch(reinterpret_cast<char*>(&out) + at, 1);
}

/// Converts a sample. If its time runs backwards or exceeds the longest session, the pose becomes invalid and the time
/// is `last`.
haptics::HandSample to_hand(const typodont_sample& sample, Nanos last) noexcept {
  haptics::HandSample hand{sample.t_ns, to_pose(sample.X_WT), sample.pedal, sample.tool};
  if (hand.t >= last && to_seconds(hand.t) <= kLongestSession) return hand;
  hand.t = last;
  hand.X_WT.p = dvec3(std::numeric_limits<double>::quiet_NaN());
  return hand;
}

/// Writes the results of a tick to the host's structs. `made`: the tick's cut, or null.
typodont_result answer(const ServoTick& tick, const Cut* made, typodont_tick* out, typodont_cut* cut) noexcept {
  put(tick, *out);
  if (cut) {
    if (made)
      put(*made, *cut);
    else
      cut->index = 0;
  }
  return tick.faults & bits(Fault::kBadInput) ? fail(TYPODONT_BAD_INPUT, kBadPose) : typodont_result{TYPODONT_OK};
}

}  // namespace

CoreObject::CoreObject(Scene s, haptics::DeviceInfo h)
    : scene(std::move(s)),
      hand(std::move(h)),
      tools(static_cast<std::uint32_t>(haptics::tool_set(scene.servo).size())),
      shared(new Shared{start_session(scene, hand), nullptr}) {}

CoreObject::~CoreObject() {
  if (!recording) return;
  const SessionFiles files;
  recording.reset();
}

SteppedSession& CoreObject::step(const haptics::HandSample& sample) {
  shared->session.tick(sample);
  begun = true;
  record();
  return shared->session;
}

void CoreObject::record() {
  if (!recording) return;
  const SessionFiles files;
  recording->turn();
}

namespace {

/// Does the work of the tissue's thread while the servo runs on another thread: repeats the servo's new cuts in the
/// tissue, passes a new tissue patch to the servo, and writes to the recording. False if there was nothing to do.
bool carve(CoreObject& core, bool to_end = false) {
  const bool servo_is_freed = core.shared.use_count() == 1;
  const CarverSide::Read found = core.side->follow([](const Cut&) {}, to_end || servo_is_freed);
  core.side->keep_up();
  const bool offered = found.tick && core.side->offer(/*due_only=*/true);
  core.record();
  return found.cut || offered || (core.recording && found.tick);
}

typodont_result edit(typodont_core* handle, bool redo, int32_t* done) noexcept {
  return with(handle, [&](CoreObject& core) {
    const bool did = core.side ? core.side->edit(redo) : core.shared->session.edit(redo);
    core.record();
    if (done) *done = did;
  });
}

}  // namespace

}  // namespace typodont::bindings

using namespace typodont;
using namespace typodont::bindings;

typodont_result typodont_core_new(typodont_scene* scene, typodont_hand* hand, const typodont_core_options* options,
                                  typodont_core** out) {
  return with(scene, [&](SceneObject& s) {
    require(out, "NULL for the place of the handle");
    haptics::DeviceInfo info;
    // N·m; not zero, because the program assumes that the host applies torques unless its user has switched them off
    info.torque_limit = 1;
    if (hand) {
      require(!options, "both a hand and options: expected one of them");
      const HandleLock<typodont_hand> held(hand);
      if (!held) return held.why();
      info = held->device->info();
    } else if (options) {
      require(sized(options->struct_size, sizeof *options), kBadSize);
      const auto in = [](double v, double low, double high) { return v >= low && v <= high; };
      require(options->rate == 0 || in(options->rate, 10, 100'000), "rate: expected 10 to 100000 Hz, or 0");
      require(in(options->position_step, 0, 1), "position_step: expected 0 to 1 m");
      require(in(options->vibration_band, 0, 2000), "vibration_band: expected 0 to 2000 Hz");
      if (options->rate > 0) info.rate = options->rate;
      if (options->no_torque) info.torque_limit = 0;
      info.position_step = options->position_step;
      info.vibration_band = options->vibration_band;
    }
    if (info.address.empty()) info.address = "program:";
    const SessionFiles files;  // locks access to session files, because the scene may continue a recorded session
    *out = make_handle<typodont_core>(std::make_unique<CoreObject>(s.scene, info));
    return typodont_result{TYPODONT_OK};
  });
}

typodont_result typodont_core_free(typodont_core* core) {
  return free_handle(core);
}

typodont_result typodont_core_tick(typodont_core* core, const typodont_sample* sample, typodont_tick* out,
                                   typodont_cut* cut) {
  return with(core, [&](CoreObject& c) {
    if (!usable(sample, out, cut)) return fail(TYPODONT_BAD_INPUT, kSampleAndTick);
    if (sample->tool >= c.tools) return fail(TYPODONT_BAD_INPUT, kNoSuchTool);
    if (c.shared->patch) return fail(TYPODONT_BAD_INPUT, kGivenAway);
    const IeeeArithmetic ieee;
    prefetch(*out);
    const SteppedSession& session = c.step(to_hand(*sample, c.shared->session.last().t));
    return answer(session.last(), session.cut(), out, cut);
  });
}

typodont_result typodont_core_run(typodont_core* core, typodont_hand* hand, typodont_tick* ticks, size_t capacity,
                                  size_t* count) {
  return with(core, [&](CoreObject& c) {
    require(count, "NULL for the place of the count");
    require(!ticks || capacity == 0 || sized(ticks->struct_size, sizeof *ticks), kBadSize);
    if (c.shared->patch) return fail(TYPODONT_BAD_INPUT, kGivenAway);
    const HandleLock<typodont_hand> held(hand);
    if (!held) return held.why();
    const IeeeArithmetic ieee;
    const std::uint32_t stride = ticks && capacity > 0 ? ticks->struct_size : 0;
    haptics::HandSample sample;
    for (*count = 0; *count < capacity; ++*count) {
      if (!held->device->read(sample)) return fail(TYPODONT_END, "the hand has come to its end");
      require(sample.tool < c.tools, kNoSuchTool);
      sample.faults = held->device->faults();
      const ServoTick& tick = c.step(sample).last();
      held->device->write(tick.f_T_W, tick.tau_T_W);
      if (!ticks) continue;
      typodont_tick& out = element(ticks, *count, stride);
      out.struct_size = stride;
      put(tick, out);
    }
    return typodont_result{TYPODONT_OK};
  });
}

typodont_result typodont_core_servo(typodont_core* core, const double* start_W, typodont_servo** out) {
  return with(core, [&](CoreObject& c) {
    // m; a hand that is farther from the origin than this is treated as invalid input, as in the servo
    constexpr double kWorkspace = 100;
    require(start_W && out && glm::length(to_vec(start_W)) < kWorkspace,
            "the place where the tool starts: NULL, not finite, or too far away");
    require(!c.shared->patch, "the servo was given away already");
    require(!c.begun, "the servo can be given away before the first tick only");
    c.shared->patch = std::make_unique<haptics::PatchExchange>(c.carver());
    ServoTick start;
    start.X_WT.p = start.X_WG.p = to_vec(start_W);
    EventLogs& event_logs = c.shared->session.event_logs();
    c.side.emplace(c.carver(), *c.shared->patch, event_logs, start);
    c.shared->patch->offer(c.carver(), start.X_WG.p);
    auto servo = std::make_unique<ServoObject>(
        ServoObject{c.shared, {c.shared->session.servo(), event_logs.servo, c.hand.rate}, c.tools, {}, {}});
    *out = make_handle<typodont_servo>(std::move(servo));
  });
}

typodont_result typodont_servo_tick(typodont_servo* servo, const typodont_sample* sample, typodont_tick* out,
                                    typodont_cut* cut) {
  const HandleLock<typodont_servo> held(servo);
  if (!held) return held.why();
  ServoObject& s = *held;
  if (!usable(sample, out, cut)) return fail(TYPODONT_BAD_INPUT, kSampleAndTick);
  if (sample->tool >= s.tools) return fail(TYPODONT_BAD_INPUT, kNoSuchTool);
  const IeeeArithmetic ieee;
  s.side.take_patch(*s.shared->patch, now());
  const bool did_cut = s.shared->session.servo().tick(to_hand(*sample, s.tick.t), s.tick, s.cut);
  s.tick.cpu_time = 0;
  s.side.write(s.tick, did_cut ? &s.cut : nullptr);
  return answer(s.tick, did_cut ? &s.cut : nullptr, out, cut);
}

typodont_result typodont_core_carve(typodont_core* core, int32_t* worked) {
  return with(core, [&](CoreObject& c) {
    require(c.shared->patch != nullptr, "the servo was not given away: typodont_core_tick does all");
    const IeeeArithmetic ieee;
    const bool any = carve(c);
    if (worked) *worked = any;
  });
}

typodont_result typodont_servo_free(typodont_servo* servo) {
  return free_handle(servo);
}

typodont_result typodont_core_undo(typodont_core* core, int32_t* done) {
  return edit(core, false, done);
}

typodont_result typodont_core_redo(typodont_core* core, int32_t* done) {
  return edit(core, true, done);
}

typodont_result typodont_core_mesh(typodont_core* core, const typodont_mesh_part** parts, size_t* count) {
  return with(core, [&](CoreObject& c) {
    require(parts && count, "NULL for the place of the parts or of their count");
    haptics::TissueVolume& volume = c.volume();
    FieldBrick brick;
    const std::vector<glm::ivec3> changed = volume.take_changed_bricks();
    for (const glm::ivec3& key : std::exchange(c.meshed, true) ? changed : volume.surface_bricks()) {
      volume.read_brick(key, brick);
      c.mesher.put(brick);
    }
    c.vertices.clear(), c.parts.clear();
    const VoxelFrame& frame = volume.frame();
    for (const glm::ivec3& key : c.mesher.remesh()) {
      typodont_mesh_part part{};
      part.brick[0] = key.x, part.brick[1] = key.y, part.brick[2] = key.z;
      std::vector<typodont_vertex>& corners = c.vertices.emplace_back();
      if (const surface::BrickMesh* const mesh = c.mesher.find(key)) {
        for (const surface::SurfaceVertex& v : mesh->vertices) {
          const glm::vec3 p(frame.to_world(dvec3(v.position)));
          corners.push_back({{p.x, p.y, p.z},
                             {v.normal.x, v.normal.y, v.normal.z},
                             {static_cast<std::uint8_t>(v.tissue[0]), static_cast<std::uint8_t>(v.tissue[1])},
                             v.second,
                             0});
        }
        part.indices = mesh->indices.data();
        part.index_count = static_cast<std::uint32_t>(mesh->indices.size());
      }
      part.vertices = corners.data();
      part.vertex_count = static_cast<std::uint32_t>(corners.size());
      c.parts.push_back(part);
    }
    *parts = c.parts.data();
    *count = c.parts.size();
  });
}

typodont_result typodont_core_field(typodont_core* core, typodont_field* out) {
  return with(core, [&](CoreObject& c) {
    require(out && sized(out->struct_size, sizeof *out), kBadSize);
    const haptics::TissueVolume& volume = c.volume();
    glm::ivec3 low, high;
    volume.bounds(low, high);
    put(volume.frame().origin, out->origin);
    out->voxel = volume.frame().voxel;
    out->band = volume.band();
    for (int i = 0; i < 3; ++i) out->low[i] = low[i], out->high[i] = high[i];
    out->elements = c.carver().body().elements();
  });
}

typodont_result typodont_core_query(typodont_core* core, const double* points, size_t count, double* distance,
                                    uint8_t* tissue) {
  return with(core, [&](CoreObject& c) {
    require(points || count == 0, "NULL for the points");
    const haptics::TissueVolume& volume = c.volume();
    const VoxelFrame& frame = volume.frame();
    constexpr double kFarthest = 1e9;  // voxels; a point that is farther from the origin than this is refused
    for (std::size_t i = 0; i < count; ++i) {
      const dvec3 p = frame.to_voxels(to_vec(points + 3 * i));
      require(is_finite(p) && glm::length(p) < kFarthest, "a point that is not finite, or too far away");
      const glm::ivec3 low(glm::floor(p));
      const dvec3 f = p - dvec3(low);
      std::array<float, 8> d;
      std::array<Tissue, 8> labels;
      volume.copy(low, glm::ivec3(2), d.data(), labels.data());
      double sum = 0;
      std::size_t nearest = 0;
      for (std::size_t k = 0; k < 8; ++k) {  // the result has z as the fastest index
        const bool x = k & 4, y = k & 2, z = k & 1;
        sum += (x ? f.x : 1 - f.x) * (y ? f.y : 1 - f.y) * (z ? f.z : 1 - f.z) * static_cast<double>(d[k]);
        if (x == (f.x > 0.5) && y == (f.y > 0.5) && z == (f.z > 0.5)) nearest = k;
      }
      if (distance) distance[i] = sum * frame.voxel;
      if (tissue) tissue[i] = sum < 0 ? static_cast<std::uint8_t>(labels[nearest]) : std::uint8_t{0};
    }
  });
}

typodont_result typodont_core_copy(typodont_core* core, const int32_t* low, const int32_t* size, float* distance,
                                   uint8_t* tissue) {
  return with(core, [&](CoreObject& c) {
    require(low && size, "NULL for the box");
    // voxels; largest number of voxels in the box that the host may copy
    constexpr std::int64_t kMost = std::int64_t{1} << 31;
    std::int64_t count = 1;
    for (int i = 0; i < 3; ++i) {
      // voxels; largest edge length of the box, and largest absolute value of its coordinates
      constexpr int kFar = 1 << 20;
      require(size[i] > 0 && size[i] <= kFar && std::abs(low[i]) <= kFar, "a box that is empty, or too large");
      count *= size[i];
    }
    require(count <= kMost, "a box that is too large");
    static_assert(sizeof(Tissue) == 1);
    const haptics::TissueVolume& volume = c.volume();
    volume.copy({low[0], low[1], low[2]}, {size[0], size[1], size[2]}, distance, reinterpret_cast<Tissue*>(tissue));
    if (!distance) return;
    const auto voxel = static_cast<float>(volume.frame().voxel);
    for (std::int64_t i = 0; i < count; ++i) distance[i] *= voxel;
  });
}

typodont_result typodont_core_volumes(typodont_core* core, double* volumes) {
  return with(core, [&](CoreObject& c) {
    require(volumes, "NULL for the place of the volumes");
    put(c.volume().volumes(), volumes);
  });
}

typodont_result typodont_core_hash(typodont_core* core, uint64_t* hash) {
  return with(core, [&](CoreObject& c) {
    require(hash, "NULL for the place of the hash");
    *hash = c.volume().hash();
  });
}

typodont_result typodont_core_save(typodont_core* core, const char* file) {
  return with(core, [&](CoreObject& c) {
    require(file, "NULL for the file");
    c.volume().save(file);
  });
}

typodont_result typodont_core_record(typodont_core* core, const char* file, const char* trainee) {
  return with(core, [&](CoreObject& c) {
    require(file, "NULL for the file");
    require(!c.recording, "it is being recorded already");
    require(!c.begun && !c.shared->patch, "a recording begins before the first tick");
    const SessionFiles files;
    c.recording.emplace(file, c.scene, c.hand, c.volume(), c.shared->session.event_logs(), trainee ? trainee : "");
  });
}

typodont_result typodont_core_finish(typodont_core* core) {
  return with(core, [&](CoreObject& c) {
    require(c.recording.has_value(), "nothing is being recorded");
    if (c.shared->patch) {
      // Largest number of calls of carve(). These calls finish the work that existed before this function was called.
      // The servo may add new work meanwhile, so without a limit the loop might never end.
      constexpr int kRounds = 64;
      for (int i = 0; i < kRounds && carve(c, /*to_end=*/true); ++i) {
      }
    }
    const SessionFiles files;
    c.recording->finish(c.volume());
    c.recording.reset();
  });
}
