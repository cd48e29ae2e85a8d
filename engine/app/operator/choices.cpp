#include "engine/app/operator/choices.h"

#include <algorithm>

#include "engine/app/operator/library.h"
#include "engine/base/realtime.h"
#include "haptics/contact_method.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {
// Time between two searches for devices, ns; one search takes milliseconds.
constexpr Nanos kDeviceInterval = 2 * kNanosPerSecond;
}  // namespace

Choices::Choices(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w), pictures_(s, w) {
  s_.chinese = can_show(session::Language::kChinese);
  const Remembered r = remembered();
  s_.first_run = !r.any;
  set_language(session::language_named(r.language).value_or(session::system_language()));
  r.trainee.copy(s_.trainee.data(), s_.trainee.size() - 1);
  s_.record = r.record;
  s_.school.hand_in = r.hand_in;
  s_.monitor = r.monitor;
  rescan();
  for (std::size_t i = 0; i < s_.scenes.size(); ++i)
    if (s_.scenes[i].file.string() == r.scene) s_.scene = static_cast<int>(i);
  for (std::size_t i = 0; i < s_.rigs.size(); ++i)
    if (s_.rigs[i].title == r.rig) s_.rig = static_cast<int>(i);
  if (!r.hand.empty()) choose_hand(r.hand);
  s_.models = haptics::contact_method_names();
  for (std::size_t i = 0; i < s_.models.size(); ++i)
    if (s_.models[i] == r.model) s_.model = static_cast<int>(i);
  // By default, the experiment compares with the contact model mesh_lod, because it works in every exercise.
  for (std::size_t i = 0; i < s_.models.size(); ++i)
    if (s_.models[i] == "mesh_lod") s_.experiment.models[1] = static_cast<int>(i);
}

void Choices::set_language(session::Language language) {
  if (window_.set_language(language)) s_.language = language;
}

void Choices::rescan() {
  s_.scenes = find_scenes(s_);
  s_.cases.families = find_case_families(s_.language);
  window_.replace(s_.pictures, {});
  std::string texts;
  for (const SceneChoice& scene : s_.scenes) texts += scene.group + scene.title + scene.description;
  for (const auto& [name, title] : s_.cases.families) texts += title;
  window_.announce_text(texts);
  s_.hands = find_hands(s_);
  s_.real_time_refused = realtime_refusal();
  s_.rigs = find_rigs(s_);
#ifdef TYPODONT_WINDOW
  s_.monitors = display::monitors();
#endif
  const auto within = [](int& chosen, std::size_t count) {
    chosen = std::clamp(chosen, 0, std::max(static_cast<int>(count) - 1, 0));
  };
  within(s_.scene, s_.scenes.size());
  within(s_.cases.family, s_.cases.families.size());
  within(s_.hand, s_.hands.size());
  within(s_.rig, s_.rigs.size());
}

void Choices::choose_scene(const fs::path& file) {
  for (std::size_t i = 0; i < s_.scenes.size(); ++i)
    if (s_.scenes[i].file == file) s_.scene = static_cast<int>(i);
  s_.scene_shown = -1;
}

void Choices::choose_tutorial() {
  for (std::size_t i = 0; i < s_.scenes.size(); ++i)
    if (s_.scenes[i].file.stem() == "tutorial" && !s_.scenes[i].own) s_.scene = static_cast<int>(i);
  s_.first_run = s_.author = false;
}

void Choices::choose_hand(const std::string& address) {
  for (std::size_t i = 0; i < s_.hands.size(); ++i)
    if (s_.hands[i].address == address) s_.hand = static_cast<int>(i);
}

bool Choices::look_at_devices() {
  if (now() - plugged_looked_ < kDeviceInterval) return false;
  plugged_looked_ = now();
  if (plugged_.look().empty()) return false;
  const std::string chosen = s_.hands.at(static_cast<std::size_t>(s_.hand)).address;
  s_.hands = find_hands(s_);
  s_.hand = 0;
  choose_hand(chosen);
  return true;
}

void Choices::remember() const {
  Remembered r;
  r.language = session::tag_of(s_.language);
  if (s_.school.student.empty()) r.trainee = s_.trainee.data();  // the next person signs in anew
  r.record = s_.record;
  r.hand_in = s_.school.hand_in;
  r.monitor = s_.monitor;
  if (!s_.scenes.empty()) r.scene = s_.scenes[static_cast<std::size_t>(s_.scene)].file.string();
  if (!s_.hands.empty()) r.hand = s_.hands[static_cast<std::size_t>(s_.hand)].address;
  if (s_.model >= 0) r.model = s_.models[static_cast<std::size_t>(s_.model)];
  if (!s_.rigs.empty()) r.rig = s_.rigs[static_cast<std::size_t>(s_.rig)].title;
  typodont::remember(r);
}

}  // namespace typodont
