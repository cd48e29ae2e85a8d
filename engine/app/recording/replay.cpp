#include "engine/app/recording/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/recording.h"
#include "engine/app/recording/resume.h"
#include "engine/app/recording/stream_check.h"
#include "engine/app/scene.h"
#include "engine/app/stepped.h"
#include "engine/base/error.h"
#include "engine/base/realtime.h"
#include "engine/base/temporary_folder.h"
#include "engine/base/units.h"
#include "engine/contract/force_law.h"
#include "engine/session/hash.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "haptics/carver.h"
#include "haptics/lockstep.h"

namespace typodont {

namespace {

/// Private copies of the files that a recording depends on.
struct CheckedFiles {
  TemporaryFolder folder;
  std::map<std::string, std::filesystem::path> copies;  // path of each copy; key: recorded name of the file
};

/// Files in `folder` and its subfolders with the same name or the same size as the recorded file.
std::vector<std::filesystem::path> candidates(const std::filesystem::path& folder, const session::SourceFile& file) {
  namespace fs = std::filesystem;
  constexpr int kDeepest = 4, kMaxLooks = 20'000;
  std::error_code code;
  const fs::path name = fs::path(file.path).filename();
  std::vector<fs::path> found{folder / file.path};
  fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, code), end;
  for (int looks = 0; !code && it != end && looks < kMaxLooks; it.increment(code), ++looks) {
    if (it.depth() >= kDeepest) it.disable_recursion_pending();
    std::error_code own;
    if (it->is_regular_file(own) && (it->file_size(own) == file.bytes || it->path().filename() == name))
      found.push_back(it->path());
  }
  return found;
}

/// Copies the files that a recording lists. A copy has the recorded hash, and nobody else can change it, so the checked
/// bytes are the bytes that are read. Throws Error.
std::shared_ptr<const CheckedFiles> checked_files(const session::SessionHeader& header,
                                                  const std::vector<std::filesystem::path>& folders) {
  namespace fs = std::filesystem;
  auto checked = std::make_shared<CheckedFiles>();
  // The recording contains the text of the first file (the scene) and of the last file (the rig), so they are not
  // copied.
  const std::size_t end = header.files.size() - (header.rig_json.empty() || header.files.empty() ? 0 : 1);
  for (std::size_t i = 1; i < end; ++i) {
    const session::SourceFile& file = header.files[i];
    const fs::path path = file.path;
    if (path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end())
      throw Error(file.path, "", "a recording that names a file outside its folder", "a name");
    const fs::path copy = checked->folder.path() / std::to_string(i) / fs::path(file.path).filename();
    fs::create_directory(copy.parent_path());
    bool seen = false;
    const auto take = [&](const fs::path& from) {
      std::error_code code;
      if (!fs::is_regular_file(from, code)) return false;
      seen = seen || from.filename() == copy.filename();
      if (fs::file_size(from, code) != file.bytes) return false;
      std::ofstream to(copy, std::ios::binary);
      return session::describe_file(from, &to).hash == file.hash && to.flush();
    };
    bool found = take(assets_folder() / file.path);
    for (auto folder = folders.begin(); !found && folder != folders.end(); ++folder)
      for (const fs::path& from : candidates(*folder, file))
        if ((found = take(from))) break;
    if (!found) {
      std::string searched = "assets/";
      for (const fs::path& folder : folders) searched += ", " + folder.string();
      throw Error(file.path, "", seen ? "another content" : "no such file",
                  fmt::format("{}, as in the session, in {}; TYPODONT_FILES allows more folders, with ':' between them",
                              file.hash, searched));
    }
    checked->copies[file.path] = copy;
  }
  return checked;
}

/// Folders that may contain the files of a session's scene, in addition to the assets.
std::vector<std::filesystem::path> folders_of(const std::filesystem::path& session) {
  namespace fs = std::filesystem;
  std::error_code code;
  const fs::path own = fs::weakly_canonical(fs::absolute(session), code).parent_path();
  std::vector<fs::path> folders = {own};
  const fs::path users = fs::weakly_canonical(fs::absolute(user_folder()), code);
  if (std::mismatch(users.begin(), users.end(), own.begin(), own.end()).first == users.end()) folders.push_back(users);
  if (const char* more = std::getenv("TYPODONT_FILES")) {
    std::string_view rest = more;
    while (!rest.empty()) {
      const std::string_view folder = rest.substr(0, rest.find(':'));
      if (!folder.empty()) folders.emplace_back(folder);
      rest.remove_prefix(std::min(rest.size(), folder.size() + 1));
    }
  }
  return folders;
}

void repeat(haptics::Carver& carver, const StrokeEdit& edit) {
  edit.redo ? carver.redo() : carver.undo();
}

}  // namespace

Scene scene_of(const session::SessionReader& session, const ScenePlace& from) {
  // Longest chain of recordings, each of which continues the previous one.
  constexpr int kMaxRecordings = 32;
  if (from.recordings >= kMaxRecordings)
    throw Error(session.file().string(), "scene", "recordings that name each other", "an end to them");
  const session::SessionHeader& header = session.header();
  ScenePlace place(std::filesystem::absolute(session.file()).parent_path());
  place.within = folders_of(session.file());
  place.within.insert(place.within.end(), from.within.begin(), from.within.end());
  place.recordings = from.recordings + 1;
  // A recording reveals nothing by a file whose hash it already states, so listed files may be in more folders.
  std::vector<std::filesystem::path> searched = place.within;
  searched.insert(searched.end(), {user_folder(), "."});
  const auto checked = checked_files(header, searched);
  place.checked = {checked, &checked->copies};
  const std::filesystem::path scene_file = place.beside / (header.files.empty() ? "scene.json" : header.files[0].path);
  Scene scene = parse_scene(Json::parse(header.scene_json, session.file().string() + " (scene)"), scene_file, place);
  if (const std::size_t tools = haptics::tool_set(scene.servo).size(); header.tools.size() > tools)
    throw Error(session.file().string(), "header/tools", fmt::format("{} tools", header.tools.size()),
                fmt::format("the {} of its scene", tools));
  return scene;
}

bool has_other_law(const session::SessionReader& session) {
  return session.header().force_law != kForceLaw;
}

namespace {

ReplayResult rerun_with_todays_law(const session::SessionReader& session, const Scene& scene,
                                   const std::function<void(double)>& progress) {
  const RerunResult rerun = rerun_session(session, scene, {}, progress);
  ReplayResult result;
  result.truncated = session.truncated();
  result.seconds = rerun.seconds;
  result.ticks = rerun.ticks;
  result.what_differs = fmt::format(
      "it was made with another force law (by Typodont {}). With today's law, the force on the same hand differs by "
      "{:.3f} N rms and {:.3f} N at most, and the hand removes {:.3f} mm³ instead of {:.3f} mm³",
      session.header().program_version, rerun.force_off_rms, rerun.force_off_max, rerun.removed / kCubicMillimetre,
      rerun.removed_before / kCubicMillimetre);
  result.with_todays_law = rerun;
  return result;
}

}  // namespace

ReplayResult replay_session(const session::SessionReader& session, const std::function<void(double)>& progress) {
  use_ieee_arithmetic();
  const session::SessionHeader& header = session.header();
  const Scene scene = scene_of(session);
  if (has_other_law(session)) return rerun_with_todays_law(session, scene, progress);

  haptics::TissueVolume tissue = load_tissue(scene);
  const haptics::ServoSettings settings = servo_settings(scene, tissue, header.servo_rate, header.vibration_band,
                                                         header.position_step, header.gives_torque);
  haptics::LockStep steps(std::move(tissue), settings);

  ReplayResult result;
  result.truncated = session.truncated();
  StreamCheck compare(session);
  compare.volumes_at_start(scene.resume.empty() ? steps.carver().volume().volumes() : load_untouched(scene).volumes());
  Fnv1a force_hash;
  const std::vector<StrokeEdit> edits = edits_of(session);
  auto edit = edits.begin();
  // Applies all undos and redos that the session made before it created tissue patch number `patches` + 1.
  const auto edit_through = [&](std::uint32_t patches) {
    for (; edit != edits.end() && edit->patches <= patches; ++edit) {
      steps.apply_cuts(edit->cuts);
      repeat(steps.carver(), *edit);
    }
  };
  auto patch = session.patches().begin();
  constexpr std::uint64_t kChunk = 65536;
  for (std::uint64_t first = 0; first < session.tick_count(); first += kChunk) {
    for (const ServoTick& recorded : session.ticks(first, kChunk)) {
      if (!compare.covers(recorded)) break;
      for (; patch != session.patches().end() && patch->first_tick <= recorded.index; ++patch) {
        edit_through(patch->patch - 1);
        steps.apply_cuts(patch->cuts);
        steps.take_snapshot(patch->center_W, patch->patch);
        steps.adopt_snapshot();
      }
      ServoTick tick;
      Cut cut;
      const bool did_cut =
          steps.tick_servo({recorded.t, recorded.X_WT, recorded.pedal, recorded.tool, recorded.faults}, tick, cut);
      session::add_forces(force_hash, {&tick, 1});
      compare.tick(tick, recorded);
      if (did_cut) compare.cut(cut);
      ++result.ticks;
      result.seconds = static_cast<double>(recorded.index) / header.servo_rate;
      result.ticks_with_faults += recorded.faults != 0;
    }
    if (progress) progress(static_cast<double>(result.ticks) / static_cast<double>(session.tick_count()));
  }
  edit_through(UINT32_MAX);
  steps.apply_cuts(UINT64_MAX);
  const std::uint64_t field = steps.carver().volume().hash();
  result.field_hash = fmt::format("{:016x}", field);
  result.force_hash = fmt::format("{:016x}", force_hash.value);
  compare.end(steps.carver().volume());
  result.identical = !compare.difference();
  if (!result.identical) {
    result.first_difference = compare.difference()->tick;
    result.what_differs = compare.difference()->what;
  }
  if (!result.identical && session.lost().any())
    result.what_differs += "; the recording lacks " + in_words(session.lost());
  return result;
}

Scene scene_with(const session::SessionReader& session, const std::string& overrides, const std::string& where) {
  const Scene own = scene_of(session);
  const Json given = Json::parse(overrides, where);
  if (!given.is_object()) given.fail("an object with keys of a scene");
  auto json = nlohmann::ordered_json::parse(own.text);
  const auto changes = nlohmann::ordered_json::parse(overrides);
  for (const auto& [key, value] : changes.items()) {
    if (value.is_null())
      json.erase(key);
    else
      json[key] = value;
  }
  return parse_scene(Json::parse(json.dump(2), where, Json::Lines::kUnknown), own.file, own.place);
}

RerunResult rerun_session(const session::SessionReader& session, const Scene& scene, const std::filesystem::path& out,
                          const std::function<void(double)>& progress) {
  haptics::DeviceInfo hand;
  hand.address = "replay:" + session.file().string();
  hand.rate = session.header().servo_rate;
  hand.vibration_band = session.header().vibration_band;
  hand.position_step = session.header().position_step;
  hand.torque_limit = session.header().gives_torque ? std::numeric_limits<double>::infinity() : 0;
  SteppedSession today(scene, load_tissue(scene), hand);
  today.omit_times();
  std::optional<SessionRecorder> recorder;
  if (!out.empty())
    recorder.emplace(out, scene, hand, today.carver().volume(), today.event_logs(), session.header().trainee);
  RerunResult result;
  const std::vector<StrokeEdit> edits = edits_of(session);
  auto edit = edits.begin();
  const auto edit_before = [&](Nanos t) {
    for (; edit != edits.end() && edit->t < t; ++edit) {
      today.edit(edit->redo);
      if (recorder) recorder->turn();
    }
  };
  constexpr std::uint64_t kChunk = 65536;
  double force2 = 0, tool2 = 0;
  for (std::uint64_t first = 0; first < session.tick_count(); first += kChunk) {
    for (const ServoTick& recorded : session.ticks(first, kChunk)) {
      edit_before(recorded.t);
      const std::uint32_t of_hand = recorded.faults & (haptics::kNoPose | bits(Fault::kHeld));
      const ServoTick& tick = today.tick({recorded.t, recorded.X_WT, recorded.pedal, recorded.tool, of_hand});
      if (recorder) recorder->turn();
      const double off = glm::length(tick.f_T_W - recorded.f_T_W),
                   tool_off = glm::length(tick.X_WG.p - recorded.X_WG.p);
      force2 += off * off, tool2 += tool_off * tool_off;
      result.force_off_max = std::max(result.force_off_max, off);
      result.tool_off_max = std::max(result.tool_off_max, tool_off);
      result.force_max = std::max(result.force_max, glm::length(tick.f_T_W));
      result.force_max_before = std::max(result.force_max_before, glm::length(recorded.f_T_W));
      result.removed = total(tick.removed), result.removed_before = total(recorded.removed);
      result.seconds = to_seconds(tick.t);
      result.cuts = tick.cuts;
      ++result.ticks;
    }
    if (progress) progress(static_cast<double>(result.ticks) / static_cast<double>(session.tick_count()));
  }
  edit_before(std::numeric_limits<Nanos>::max());
  if (result.ticks > 0) {
    result.force_off_rms = std::sqrt(force2 / static_cast<double>(result.ticks));
    result.tool_off_rms = std::sqrt(tool2 / static_cast<double>(result.ticks));
  }
  if (recorder) recorder->finish(today.carver().volume());
  return result;
}

}  // namespace typodont
