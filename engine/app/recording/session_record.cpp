#include "engine/app/recording/session_record.h"

#include <array>
#include <system_error>

#include "engine/app/assets.h"
#include "engine/session/hash.h"
#include "haptics/solid.h"

namespace typodont {

session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::DeviceInfo& hand, const haptics::TissueVolume& tissue,
                                      double rate) {
  session::SessionHeader header;
  header.scene_json = scene.text;
  header.model = model_name(scene);
  header.hand = hand.address;
  header.tools = tool_names(scene);
  header.servo_rate = rate;
  header.vibration_band = hand.vibration_band;
  header.position_step = hand.position_step;
  header.gives_torque = hand.torque_limit > 0;
  header.voxel = tissue.frame().voxel;
  header.volumes_before = scene.resume.empty() ? tissue.volumes() : load_untouched(scene).volumes();
  const std::filesystem::path scene_file = std::filesystem::absolute(scene.file);
  std::error_code code;
  if (std::filesystem::exists(scene_file, code)) {
    header.files.push_back(session::describe_file(scene_file));
  } else {  // a program has passed the scene as text, so there is no scene file
    Fnv1a hash;
    hash.bytes(scene.text.data(), scene.text.size());
    header.files.push_back({scene_file.string(), scene.text.size(), session::to_text(hash)});
  }
  if (const auto volume = scene.tissue->find("volume")) {
    header.files.push_back(session::describe_file(std::filesystem::absolute(find_file(volume->string(), scene.place))));
  }
  const auto add_meshes = [&](const Json& solids) {
    for (const std::string& mesh : haptics::mesh_files(solids)) {
      header.files.push_back(session::describe_file(std::filesystem::absolute(find_file(mesh, scene.place))));
    }
  };
  add_meshes(*scene.tissue);
  for (const Json& item : scene.paint) add_meshes(item);
  for (const Json& item : scene.prepare) add_meshes(item);
  if (!scene.paint_file.empty())
    header.files.push_back(session::describe_file(std::filesystem::absolute(scene.paint_file)));
  if (!scene.resume.empty()) {
    header.files.push_back(session::describe_file(std::filesystem::absolute(find_file(scene.resume, scene.place))));
  }
  if (!rig_file.empty()) {
    header.rig_json = Json::load(rig_file).text();
    header.files.push_back(session::describe_file(std::filesystem::absolute(rig_file)));
  }
  header.date = session::iso_date_now();
  return header;
}

session::StreamSpec left_hand_stream() {
  return {"left_hand",
          {{"x_m", "m"}, {"y_m", "m"}, {"z_m", "m"}, {"qw", ""}, {"qx", ""}, {"qy", ""}, {"qz", ""}, {"pedal", ""}}};
}

session::StreamSpec head_stream() {
  return {"head",
          {{"eye_x_m", "m"},
           {"eye_y_m", "m"},
           {"eye_z_m", "m"},
           {"right_x", ""},
           {"right_y", ""},
           {"right_z", ""},
           {"ipd_m", "m"},
           {"view", ""}}};
}

session::StreamSpec water_stream() {
  return {"water", {{"spray", ""}, {"suction", ""}}};
}

session::StreamSpec picture_stream() {
  return {"picture",
          {{"period_s", "s"},
           {"record_s", "s"},
           {"gpu_s", "s"},
           {"motion_to_photon_s", "s"},
           {"redrawn", ""},
           {"quality_step", ""}}};
}

std::vector<double> picture_stream_row(const PictureTiming& timing) {
  return {timing.period,           timing.record,  timing.gpu,
          timing.motion_to_photon, timing.redrawn, static_cast<double>(timing.step)};
}

session::StreamSpec xr_stream() {
  return {"headset",
          {{"drawn", ""},
           {"missed", ""},
           {"pose_to_submit_s", "s"},
           {"margin_s", "s"},
           {"position_error_m", "m"},
           {"angle_error_rad", "rad"},
           {"head_x_m", "m"},
           {"head_y_m", "m"},
           {"head_z_m", "m"},
           {"head_qw", ""},
           {"head_qx", ""},
           {"head_qy", ""},
           {"head_qz", ""}}};
}

std::vector<double> xr_stream_row(const display::HmdTiming& timing) {
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  const Pose& X = timing.X_WH;
  return {timing.drawn ? 1.0 : 0.0,
          static_cast<double>(timing.missed),
          timing.pose_to_submit,
          timing.margin > -1e8 ? timing.margin : kUnknown,
          timing.judged ? timing.position_error : kUnknown,
          timing.judged ? timing.angle_error : kUnknown,
          X.p.x,
          X.p.y,
          X.p.z,
          X.R.w,
          X.R.x,
          X.R.y,
          X.R.z};
}

std::string_view view_name(render::View view) noexcept {
  switch (view) {
    case render::View::kSection:
      return "section";
    case render::View::kXray:
      return "xray";
    case render::View::kDifference:
      return "difference";
    case render::View::kLook:
      break;
  }
  return "look";
}

session::StreamSpec sound_stream() {
  return {"sound",
          {{"spindle_rad_per_s", "rad/s"},
           {"pedal", ""},
           {"contact_area_m2", "m2"},
           {"force_N", "N"},
           {"removal_m3_per_s", "m3/s"},
           {"slip_m_per_s", "m/s"},
           {"tissue", ""},
           {"latency_s", "s"}}};
}

namespace {

constexpr Nanos kSoundEvery = 10'000'000;  // ns, time between two samples of the parameters of the sound
// ns, if a fault ends and occurs again within this time, the second occurrence is not recorded
constexpr Nanos kFaultAgain = kNanosPerSecond;

std::vector<bool> rotating_tools(const Scene& scene) {
  std::vector<bool> turn;
  for (const haptics::Tool& tool : haptics::tool_set(scene.servo)) turn.push_back(tool.turns());
  return turn;
}

}  // namespace

TickNotes::TickNotes(const Scene& scene, std::optional<std::size_t> sound)
    : tools_(tool_names(scene)), sound_(sound), voice_(rotating_tools(scene)) {
  fault_seen_.fill(-2 * kFaultAgain);
}

void TickNotes::add(const ServoTick& tick, session::SessionWriter& writer, double sound_latency) noexcept {
  if (tick.tool != tool_ || (first_ && tools_.size() > 1)) {
    tool_ = tick.tool;
    if (tool_ < tools_.size()) writer.event(tick.t, session::EventKind::kTool, tools_[tool_]);
  }
  for (std::size_t bit = 0; tick.faults >> bit != 0 && bit < fault_seen_.size(); ++bit) {
    if (!(tick.faults >> bit & 1u)) continue;
    if (tick.t - fault_seen_[bit] > kFaultAgain) {
      writer.event(tick.t, session::EventKind::kFault, session::fault_name(1u << bit));
    }
    fault_seen_[bit] = tick.t;
  }
  if (sound_) {
    const audio::SoundState s = voice_.state_of(tick);
    if (first_ || tick.t - sounded_ >= kSoundEvery) {
      sounded_ = tick.t;
      writer.append(*sound_, tick.t,
                    std::array{s.spindle, s.pedal, s.contact_area, s.force, s.removal_rate, s.slip_speed,
                               static_cast<double>(s.tissue), sound_latency});
    }
  }
  first_ = false;
}

session::SessionResult session_result(const haptics::TissueVolume& tissue) {
  session::SessionResult result;
  result.volumes_after = tissue.volumes();
  result.has_volumes = true;
  result.field_hash = tissue.hash();
  return result;
}

}  // namespace typodont
