#include "engine/app/recording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "engine/app/assets.h"
#include "engine/base/error.h"
#include "engine/base/sha256.h"
#include "engine/base/units.h"
#include "engine/session/hash.h"

namespace typodont {

namespace {

/// The address of a hand's device. If it names a file, the folders are left out: they may identify users and patients.
std::string without_folders(const std::string& address) {
  std::error_code code;
  for (const std::size_t start : {std::size_t{0}, address.find(':') + 1}) {
    const std::filesystem::path file = address.substr(start);
    if (std::filesystem::is_regular_file(file, code)) return address.substr(0, start) + file.filename().string();
  }
  return address;
}

/// The file to which a text in the scene refers, and the file's name in a recording. Empty if the text refers to no
/// file, or to an asset that refers to further files.
std::optional<std::pair<std::filesystem::path, std::string>> named_file(const std::string& text,
                                                                        const ScenePlace& place) {
  namespace fs = std::filesystem;
  fs::path file;
  try {
    if (!fs::path(text).has_extension()) return std::nullopt;
    file = find_file(text, place);
  } catch (const std::exception&) {
    return std::nullopt;
  }
  std::error_code code;
  if (!fs::is_regular_file(file, code)) return std::nullopt;
  if (place.checked && place.checked->contains(text)) return std::pair(file, text);
  const fs::path in_assets =
      fs::absolute(file).lexically_normal().lexically_relative(fs::absolute(assets_folder()).lexically_normal());
  if (in_assets.empty() || *in_assets.begin() == "..") return std::pair(file, file.filename().string());
  if (in_assets.extension() == ".json") return std::nullopt;
  return std::pair(file, in_assets.string());
}

/// Adds to the list all files that the scene's text names, and replaces their paths by file names. True if the text
/// changed. Throws Error.
bool list_files(nlohmann::ordered_json& json, const ScenePlace& place, std::vector<session::SourceFile>& files) {
  bool changed = false;
  if (json.is_structured()) {
    // Skips the keys "row" and "model": a row of teeth or a contact model reads further files beside its own file.
    for (auto& [key, value] : json.items())
      if (!json.is_object() || (key != "row" && key != "model")) changed = list_files(value, place, files) || changed;
  }
  if (!json.is_string()) return changed;
  const auto named = named_file(json.get<std::string>(), place);
  if (!named) return changed;
  session::SourceFile file = session::describe_file(named->first);
  file.path = named->second;
  const auto known = std::find_if(files.begin() + 1, files.end(), [&](const auto& f) { return f.path == file.path; });
  if (known == files.end()) {
    files.push_back(file);
  } else if (known->hash != file.hash) {
    throw Error(named->first.string(), "", "another file of this name in the same scene", "different names");
  }
  changed = json != file.path;
  json = file.path;
  return changed;
}

}  // namespace

session::SessionHeader session_header(const Scene& scene, const std::filesystem::path& rig_file,
                                      const haptics::DeviceInfo& hand, const haptics::TissueVolume& tissue,
                                      double rate) {
  session::SessionHeader header;
  header.model = model_name(scene);
  header.hand = without_folders(hand.address);
  header.tools = tool_names(scene);
  header.servo_rate = rate;
  header.vibration_band = hand.vibration_band;
  header.position_step = hand.position_step;
  header.gives_torque = hand.torque_limit > 0;
  header.voxel = tissue.frame().voxel;
  header.volumes_before = scene.resume.empty() ? tissue.volumes() : load_untouched(scene).volumes();
  Sha256 hash;
  hash.bytes(scene.text.data(), scene.text.size());
  header.files.push_back({scene.file.filename().string(), scene.text.size(), hash.text()});
  nlohmann::ordered_json text = nlohmann::ordered_json::parse(scene.text);
  header.scene_json = list_files(text, scene.place, header.files) ? text.dump(2) : scene.text;
  if (!rig_file.empty()) {
    header.rig_json = Json::load(rig_file).text();
    header.files.push_back(session::describe_file(rig_file));
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
  constexpr std::array<std::string_view, 5> kViewNames{"look", "section", "xray", "difference", "temperature"};
  return kViewNames[static_cast<std::size_t>(view)];
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

constexpr Nanos kSoundEvery = 10'000'000;  // ns, interval between samples of the sound's parameters
// A fault that ends and occurs again within this time is recorded only once, ns.
constexpr Nanos kFaultAgain = kNanosPerSecond;

std::vector<bool> rotating_tools(const Scene& scene) {
  std::vector<bool> turn;
  for (const haptics::Tool& tool : haptics::tool_set(scene.servo)) turn.push_back(tool.turns());
  return turn;
}

}  // namespace

session::SessionResult session_result(const haptics::TissueVolume& tissue) {
  session::SessionResult result;
  result.volumes_after = tissue.volumes();
  result.has_volumes = true;
  result.field_hash = tissue.hash();
  return result;
}

session::SessionEvent event_of(const StrokeEdit& edit) {
  const nlohmann::ordered_json text{{"cuts", edit.cuts}, {"patches", edit.patches}};
  return {edit.t, edit.redo ? session::EventKind::kRedo : session::EventKind::kUndo, text.dump()};
}

session::SessionEvent event_of(const LoosePiece& piece) {
  nlohmann::ordered_json text{{"cut", piece.cut}};
  for (int axis = 0; axis < 3; ++axis) text["center_mm"].push_back(piece.center_W[axis] / kMillimetre);
  text["radius_mm"] = piece.radius / kMillimetre;
  for (int i = 1; i < kTissueCount; ++i) {
    const double mm3 = piece.removed[static_cast<std::size_t>(i)] / kCubicMillimetre;
    if (mm3 > 0) text["mm3"][std::string(name_of(static_cast<Tissue>(i)))] = mm3;
  }
  return {piece.t, session::EventKind::kPiece, text.dump()};
}

std::optional<LoosePiece> piece_of(const session::SessionEvent& event) {
  if (event.kind != session::EventKind::kPiece) return std::nullopt;
  const Json json = Json::parse(event.text, "session event");
  json.allow_only({"cut", "center_mm", "radius_mm", "mm3"});
  LoosePiece piece;
  piece.cut = static_cast<std::uint64_t>(json["cut"].number(0, 1e15));
  piece.t = event.t;
  piece.center_W = json["center_mm"].vec3() * kMillimetre;
  piece.radius = json["radius_mm"].number(0, 1e3) * kMillimetre;
  if (const auto volumes = json.find("mm3"))
    for (int i = 1; i < kTissueCount; ++i)
      if (const auto volume = volumes->find(std::string(name_of(static_cast<Tissue>(i)))))
        piece.removed[static_cast<std::size_t>(i)] = volume->number(0, 1e6) * kCubicMillimetre;
  return piece;
}

std::optional<StrokeEdit> edit_of(const session::SessionEvent& event) {
  if (event.kind != session::EventKind::kUndo && event.kind != session::EventKind::kRedo) return std::nullopt;
  const Json json = Json::parse(event.text, "session event");
  json.allow_only({"cuts", "patches"});
  const auto count = [&](const char* key, double most) {
    const double n = json[key].number();
    if (!(n >= 0 && n <= most && n == std::floor(n))) json[key].fail("a count");
    return n;
  };
  return StrokeEdit{event.t, event.kind == session::EventKind::kRedo, static_cast<std::uint64_t>(count("cuts", 9e15)),
                    static_cast<std::uint32_t>(count("patches", 4e9))};
}

std::vector<StrokeEdit> edits_of(const session::SessionReader& session) {
  std::vector<StrokeEdit> edits;
  for (const session::SessionEvent& event : session.events()) {
    if (const auto edit = edit_of(event)) edits.push_back(*edit);
  }
  return edits;
}

namespace {

std::optional<std::size_t> stream_of(const session::SessionHeader& header, const session::StreamSpec& spec) {
  const auto& streams = header.streams;
  const auto at = std::ranges::find(streams, spec.name, &session::StreamSpec::name);
  return at == streams.end() ? std::nullopt : std::optional(static_cast<std::size_t>(at - streams.begin()));
}

session::SessionHeader timeless_header(const Scene& scene, const haptics::DeviceInfo& hand,
                                       const haptics::TissueVolume& tissue, const std::string& trainee) {
  session::SessionHeader header = session_header(scene, {}, hand, tissue, hand.rate);
  header.trainee = trainee;
  header.date.clear();
  return header;
}

session::WriterOptions whole_or_nothing() {
  session::WriterOptions options;
  options.whole_or_nothing = true;
  return options;
}

}  // namespace

SessionRecorder::SessionRecorder(const std::filesystem::path& file, const Scene& scene,
                                 const session::SessionHeader& header, const EventLogs& event_logs,
                                 const session::WriterOptions& options, std::function<double()> sound_latency)
    : writer_(file, header, options),
      tools_(tool_names(scene)),
      voice_(rotating_tools(scene)),
      sound_latency_(std::move(sound_latency)),
      sound_(stream_of(header, sound_stream())),
      left_(stream_of(header, left_hand_stream())),
      head_(stream_of(header, head_stream())),
      water_(stream_of(header, water_stream())),
      picture_(stream_of(header, picture_stream())),
      headset_(stream_of(header, xr_stream())),
      servo_(event_logs.servo),
      carver_(event_logs.carver),
      view_(event_logs.view),
      hand_(event_logs.left),
      loop_(event_logs.loop) {
  fault_seen_.fill(-2 * kFaultAgain);
}

SessionRecorder::SessionRecorder(const std::filesystem::path& file, const Scene& scene, const haptics::DeviceInfo& hand,
                                 const haptics::TissueVolume& tissue, const EventLogs& event_logs,
                                 const std::string& trainee)
    : SessionRecorder(file, scene, timeless_header(scene, hand, tissue, trainee), event_logs, whole_or_nothing()) {}

void SessionRecorder::store(const ServoTick& tick) {
  lost_ticks_ += tick.index - std::exchange(next_tick_, tick.index + 1);
  writer_.append({&tick, 1});
  note(tick);
}

void SessionRecorder::note(const ServoTick& tick) {
  const bool first = !std::exchange(noted_, true);
  if (tick.tool != tool_ || (first && tools_.size() > 1)) {
    tool_ = tick.tool;
    if (tool_ < tools_.size()) writer_.event(tick.t, session::EventKind::kTool, tools_[tool_]);
  }
  for (std::size_t bit = 0; tick.faults >> bit != 0 && bit < fault_seen_.size(); ++bit) {
    if (!(tick.faults >> bit & 1u)) continue;
    if (tick.t - fault_seen_[bit] > kFaultAgain)
      writer_.event(tick.t, session::EventKind::kFault, session::fault_name(1u << bit));
    fault_seen_[bit] = tick.t;
  }
  if (!sound_) return;
  const audio::SoundState s = voice_.state_of(tick);
  if (!first && tick.t - sounded_ < kSoundEvery) return;
  sounded_ = tick.t;
  writer_.append(*sound_, tick.t,
                 std::array{s.spindle, s.pedal, s.contact_area, s.force, s.removal_rate, s.slip_speed,
                            static_cast<double>(s.tissue), sound_latency_ ? sound_latency_() : std::nan("")});
}

void SessionRecorder::store(const Cut& cut) {
  lost_cuts_ += cut.index - std::exchange(next_cut_, cut.index + 1);
  writer_.append({&cut, 1});
}

void SessionRecorder::store(const PatchUse& use) {
  writer_.append({&use, 1});
}

void SessionRecorder::store(const StrokeEdit& edit) {
  writer_.append(event_of(edit));
}

void SessionRecorder::store(const LoosePiece& piece) {
  writer_.append(event_of(piece));
}

void SessionRecorder::store(const SeenFrom& seen) {
  if (!head_) return;
  if (std::exchange(viewed_, seen.view) != seen.view)
    writer_.event(seen.t, session::EventKind::kView, view_name(seen.view));
  const dvec3 &eye = seen.eye_W, &right = seen.right_W;
  writer_.append(*head_, seen.t,
                 std::array{eye.x, eye.y, eye.z, right.x, right.y, right.z, seen.ipd, static_cast<double>(seen.view)});
}

void SessionRecorder::store(const WaterSwitch& water) {
  if (water_) writer_.append(*water_, water.t, std::array{water.spray ? 1.0 : 0.0, water.suction ? 1.0 : 0.0});
}

// Pictures before the first tick are not stored.
void SessionRecorder::store(const PictureTiming& timing) {
  if (picture_ && timing.t >= 0) writer_.append(*picture_, timing.t, picture_stream_row(timing));
}

void SessionRecorder::store(const display::HmdTiming& timing) {
  if (headset_ && timing.t >= 0) writer_.append(*headset_, timing.t, xr_stream_row(timing));
}

void SessionRecorder::turn() {
  const auto store_event = [this](const auto& event) { store(event); };
  // Servo events first: the carver's log then already contains each undo or redo whose tissue patch the servo used.
  for (ServoEvent event; servo_.next(event);) std::visit(store_event, event);
  for (CarverEvent event; carver_.next(event);) std::visit(store_event, event);
  for (ViewEvent event; view_.next(event);) std::visit(store_event, event);
  for (haptics::HandSample left; hand_.next(left);) {
    if (!left_ || left.t < 0) continue;
    const Pose& X = left.X_WT;
    writer_.append(*left_, left.t, std::array{X.p.x, X.p.y, X.p.z, X.R.w, X.R.x, X.R.y, X.R.z, left.pedal});
  }
  if (LoopReport report; loop_.newest(report)) writer_.loop(report);
  const std::uint64_t servo = std::max(servo_.lost(), lost_ticks_ + lost_cuts_);
  writer_.count_ring_losses(lost_ticks_, lost_cuts_,
                            servo - lost_ticks_ - lost_cuts_ + carver_.lost() + view_.lost() + hand_.lost());
}

std::uint64_t SessionRecorder::finish(const haptics::TissueVolume& tissue) {
  turn();
  const session::SessionResult result = session_result(tissue);
  if (!writer_.finish(result)) throw RunFailure(writer_.status().message);
  return result.field_hash;
}

}  // namespace typodont
