#include "engine/app/operator/library.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdlib>
#include <ctime>
#include <nlohmann/json.hpp>

#include "engine/app/assets.h"
#include "engine/app/cases/case.h"
#include "engine/app/scene.h"
#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/display/display_rig.h"
#include "haptics/devices.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

/// A title from a file name: "molar-caries" becomes "Molar caries".
std::string title_of(std::string name) {
  std::replace(name.begin(), name.end(), '-', ' ');
  std::replace(name.begin(), name.end(), '_', ' ');
  if (!name.empty()) name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  return name;
}

/// An exercise's scene in the list assets/curriculum.json.
struct Listed {
  std::string scene;  // name of the scene's file without ".json"
  std::string group;  // heading over the scene in the list
};

/// The listed scenes, in the first page's order. Throws Error.
std::vector<Listed> curriculum(session::Language language) {
  std::vector<Listed> listed;
  for (const Json& group : Json::load(assets_folder() / "curriculum.json")["groups"].items()) {
    const std::string title = session::read_task_text(group["title"]).in(language);
    for (const Json& scene : group["scenes"].items()) listed.push_back({scene.string(), title});
  }
  return listed;
}

fs::path memory_file() {
  return user_folder() / "settings.json";
}

}  // namespace

std::string file_name_of(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const auto u = static_cast<unsigned char>(c);
    out += std::isalnum(u) || u >= 0x80 || c == '-' || c == '.' ? c : '_';
  }
  while (!out.empty() && out.front() == '.') out.erase(0, 1);
  return out;
}

std::vector<SceneChoice> find_scenes(const OperatorState& s) {
  std::vector<SceneChoice> scenes;
  const fs::path own = user_folder() / "scenes";
  const std::vector<Listed> listed = curriculum(s.language);
  const auto place = [&](const fs::path& file) {
    return std::find_if(listed.begin(), listed.end(), [&](const Listed& l) { return l.scene == file.stem(); });
  };
  for (const fs::path& folder : {assets_folder() / "scenes", own}) {
    std::vector<fs::path> files = files_in(folder, ".json");
    if (folder != own)
      std::stable_sort(files.begin(), files.end(),
                       [&](const fs::path& a, const fs::path& b) { return place(a) < place(b); });
    for (const fs::path& file : files) {
      SceneChoice choice;
      choice.file = file;
      choice.own = folder == own;
      if (const auto l = place(file); !choice.own && l != listed.end()) choice.group = l->group;
      choice.title = title_of(file.stem().string());
      try {
        const Json json = Json::load(file);
        choice.name = json.string_or("name", file.stem().string());
        choice.title = title_of(choice.name);
        choice.description = json.string_or("description", "");
        if (const auto block = json.find("task")) {
          const session::Task task = session::read_task(*block);
          if (!task.title.empty()) choice.title = task.title.in(s.language);
          choice.description = task.goal.in(s.language);
        }
        if (const auto made = case_in(json)) {
          choice.group = s.text("op.cases");
          choice.title += fmt::format(" · {} · {}", s.number(made->difficulty, 2), made->seed);
        }
        const Scene scene = read_scene(file);
        choice.model = model_name(scene);
        choice.jaw = scene.implant || (choice.own && !json.has("case") && !volume_file(scene).empty());
      } catch (const std::exception& e) {
        choice.fault = e.what();
      }
      scenes.push_back(std::move(choice));
    }
  }
  std::ranges::stable_partition(scenes, [&](const SceneChoice& one) { return one.group != s.text("op.cases"); });
  return scenes;
}

std::vector<std::pair<std::string, std::string>> find_case_families(session::Language language) {
  std::vector<std::pair<std::string, std::string>> families;
  for (const CaseFamily& family : case_families()) families.emplace_back(family.name, family.title.in(language));
  return families;
}

std::vector<HandEntry> find_hands(const OperatorState& s) {
  std::vector<HandEntry> hands;
  for (const auto& d : haptics::list_devices()) {
    // Skips pedals, which have no address, and the mouse, for which a separate entry is added.
    if (d.address.empty() || d.address.starts_with("mouse:")) continue;
    HandEntry choice{d.address, d.model, d.kind, d.permitted};
    if (d.force_limit > 0) choice.detail += fmt::format(", {:g} N", d.force_limit);
    if (!d.permitted) choice.detail += ": " + d.mend;
    hands.push_back(std::move(choice));
  }
  hands.push_back({"mouse:", s.text("op.mouse"), s.text("op.mouse_detail"), true});
  hands.push_back({"", s.text("op.other_hand"), "", true});
  return hands;
}

std::vector<RigChoice> find_rigs(const OperatorState& s) {
  std::vector<RigChoice> rigs{{{}, s.text("op.this_window"), true}, {{}, s.text("op.second_window"), false}};
  const fs::path shipped = assets_folder() / "rigs";
  for (const fs::path& folder : {shipped, user_folder() / "rigs"}) {
    for (const fs::path& file : files_in(folder, ".json")) {
      try {
        const display::DisplayRig rig = display::load_rig(file);
        if (rig.kind == display::DisplayKind::kOffscreen) continue;
        // Skips shipped rigs for a window, because each exercise chooses its own (usual_rig()).
        if (rig.kind == display::DisplayKind::kWindow && folder == shipped) continue;
        const bool mirror = folder == shipped && file.stem() == "mirror";
        const std::string title = rig.kind == display::DisplayKind::kHmd ? s.text("op.headset")
                                  : mirror                               ? s.text("op.half_mirror")
                                                                         : title_of(file.stem().string());
        rigs.push_back({file, title, false});
      } catch (const Error&) {
        continue;  // incomplete files, and files of another version, are not listed
      }
    }
  }
  return rigs;
}

std::string date_and_time() {
  const std::time_t t = std::time(nullptr);
  std::tm local{};
  localtime_r(&t, &local);
  char date[32];
  std::strftime(date, sizeof date, "%Y-%m-%d_%H-%M-%S", &local);
  return date;
}

fs::path new_session_file(const std::string& trainee, const std::string& scene) {
  const std::string who = file_name_of(trainee);
  const fs::path folder = user_folder() / "sessions" / (who.empty() ? "guest" : who);
  make_folder(folder);
  return folder / fmt::format("{}_{}.h5", date_and_time(), file_name_of(scene));
}

fs::path expert_folder(const fs::path& trainee_folder) {
  return trainee_folder.parent_path() / "expert";
}

fs::path temporary_recording_file() {
  const fs::path folder = user_folder() / "sessions" / ".unkept";
  std::error_code code;
  fs::create_directories(folder, code);
  if (code) return {};
  for (const auto& entry : fs::directory_iterator(folder, code)) {
    const int process = std::atoi(entry.path().stem().c_str());
    if (process > 0 && process != getpid() && kill(process, 0) != 0 && errno == ESRCH) fs::remove(entry.path(), code);
  }
  const fs::path file = folder / fmt::format("{}.h5", getpid());
  // All sessions of a process use the same file name, and the program refuses to overwrite a file that it has read.
  fs::remove(file, code);
  return file;
}

session::Language user_language(const std::string& wanted) {
  if (!wanted.empty()) {
    const auto language = session::language_named(wanted);
    if (!language) throw Error("--language", "", wanted, "en, de or zh");
    return *language;
  }
  return session::language_named(remembered().language).value_or(session::system_language());
}

Remembered remembered() {
  Remembered r;
  std::error_code code;
  if (!fs::is_regular_file(memory_file(), code)) return r;
  try {
    const Json json = Json::load(memory_file());
    r.language = json.string_or("language", "");
    r.trainee = json.string_or("trainee", "");
    r.scene = json.string_or("scene", "");
    r.hand = json.string_or("hand", "");
    r.rig = json.string_or("rig", "");
    r.record = json.boolean_or("record", true);
    r.monitor = static_cast<int>(json.number_or("monitor", -1, -1, 64));
    r.model = json.string_or("model", "");
    r.hand_in = json.boolean_or("hand_in", true);
    r.any = true;
    // If the file is damaged or of another version, the state is that of a first run.
  } catch (const Error&) {
  }
  return r;
}

void remember(const Remembered& r) {
  const nlohmann::ordered_json json = {{"language", r.language}, {"trainee", r.trainee}, {"scene", r.scene},
                                       {"hand", r.hand},         {"rig", r.rig},         {"record", r.record},
                                       {"monitor", r.monitor},   {"model", r.model},     {"hand_in", r.hand_in}};
  try {
    std::error_code code;
    fs::create_directories(user_folder(), code);
    write_file_atomically(memory_file(), json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n",
                          FileKind::kJson, Over::kItsInput);
    // If the disk is full or read-only, nothing is stored. This is no error.
  } catch (const Error&) {
  }
}

}  // namespace typodont
