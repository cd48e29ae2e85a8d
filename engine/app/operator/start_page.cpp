// The start page: exercise, hand and picture, then the session.
#include <fmt/format.h>

#include "engine/app/operator/widgets.h"
#include "engine/display/keys.h"

namespace typodont {

namespace {

using namespace widgets;
constexpr std::array<const char*, 3> kLanguages = {"English", "Deutsch", "\xe4\xb8\xad\xe6\x96\x87"};

void draw_header(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  title("Typodont", w);
  ImGui::SameLine(0, u);
  ImGui::AlignTextToFramePadding();
  dim(s.text("op.subtitle"));

  const char* doctor = s.text("op.check_computer");
  const char* experiment = s.text("op.experiment");
  const std::string archive = fmt::format("{}   {}", s.text("op.archive"), shortcut(Ask::kArchive).name);
  const float right = ImGui::CalcTextSize(doctor).x + ImGui::CalcTextSize(s.text("op.keys")).x +
                      ImGui::CalcTextSize(archive.c_str()).x + ImGui::CalcTextSize(experiment).x + 20 * u;
  ImGui::SameLine(ImGui::GetWindowWidth() - right);
  if (ImGui::Button(archive.c_str())) s.ask(Ask::kArchive);
  ImGui::SameLine();
  if (ImGui::Button(experiment)) s.ask(Ask::kExperiment);
  ImGui::SameLine();
  if (ImGui::Button(doctor)) s.ask(Ask::kDoctor);
  ImGui::SameLine();
  if (ImGui::Button(s.text("op.keys"))) s.help = true;
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1);
  const auto current = static_cast<std::size_t>(s.language);
  // The name "中文" is shown only in the Chinese window, whose font contains these characters.
  const auto shown = [&](std::size_t i) {
    return i == 2 && s.language != session::Language::kChinese ? "Chinese" : kLanguages[i];
  };
  if (ImGui::BeginCombo("##language", shown(current))) {
    for (std::size_t i = 0; i < kLanguages.size(); ++i) {
      const bool usable = i != 2 || s.chinese;
      const std::string label = usable ? shown(i) : fmt::format("{} (apt install fonts-wqy-microhei)", shown(i));
      if (ImGui::Selectable(label.c_str(), i == current, usable ? 0 : ImGuiSelectableFlags_Disabled))
        s.ask(Ask::kLanguage, static_cast<int>(i));
    }
    ImGui::EndCombo();
  }
}

/// Draws the picture, scaled to the width; without a picture, an empty field of the same size.
void draw_picture(OperatorState& s, InterfaceWindow& w, int picture, float width) {
  if (picture >= 0 && picture < static_cast<int>(s.pictures.size())) {
    const gpu::Image& image = s.pictures[static_cast<std::size_t>(picture)];
    const float height =
        width * static_cast<float>(image.options.size.height) / static_cast<float>(image.options.size.width);
    ImGui::Image(w.texture(image), {width, height});
    return;
  }
  const ImVec2 at = ImGui::GetCursorScreenPos(), size{width, width * 0.5625f};
  ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + size.x, at.y + size.y}, ImGui::GetColorU32(ImGuiCol_FrameBg),
                                            6);
  ImGui::Dummy(size);
}

void draw_scenes(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const float u = w.style().unit;
  const PagePanel panel("scenes", s.text("op.exercise"), size, w);
  if (step_through(s.scene, s.scenes.size())) s.scene_shown = -1;
  if (s.scenes.empty()) dim_wrapped(s.text("op.no_scenes"));
  for (std::size_t i = 0; i < s.scenes.size(); ++i) {
    const SceneChoice& scene = s.scenes[i];
    if (!scene.group.empty() && (i == 0 || scene.group != s.scenes[i - 1].group)) dim(scene.group);
    ImGui::PushID(static_cast<int>(i));
    const ImVec2 at = ImGui::GetCursorPos();
    const float row_height = 3.4f * u;
    if (ImGui::Selectable("##scene", static_cast<int>(i) == s.scene, ImGuiSelectableFlags_AllowDoubleClick,
                          {0, row_height})) {
      s.scene = static_cast<int>(i);
      if (ImGui::IsMouseDoubleClicked(0)) s.ask(Ask::kStart);
    }
    if (static_cast<int>(i) == s.scene && s.scene_shown != s.scene) {
      ImGui::SetScrollHereY(0.5f);
      s.scene_shown = s.scene;
    }
    const ImVec2 after = ImGui::GetCursorPos();
    ImGui::SetCursorPos({at.x + 0.6f * u, at.y + 0.45f * u});
    const float room = ImGui::GetContentRegionAvail().x - 0.4f * u;
    const float own = scene.own ? ImGui::CalcTextSize(s.text("op.own")).x + ImGui::GetStyle().ItemSpacing.x : 0;
    one_line(scene.title, room - own);
    if (scene.own) {
      ImGui::SameLine();
      dim(s.text("op.own"));
    }
    ImGui::SetCursorPos({at.x + 0.6f * u, at.y + 1.75f * u});
    ImGui::PushFont(w.style().small);
    const std::string& line = scene.fault.empty() ? scene.description : scene.fault;
    colored(fitted(line, room), scene.fault.empty() ? kDim : kBad);
    ImGui::PopFont();
    ImGui::SetCursorPos(after);
    ImGui::PopID();
  }
}

/// Makes cases: the next one of the trainee's path, or one by family, difficulty and number.
void draw_cases(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("cases", s.text("op.cases"), size, w);
  CaseForm& form = s.cases;
  const bool can = !s.busy && !form.families.empty();
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  ask_button(s, Ask::kNextCase, s.text("op.next_case"), {half, 0}, can);
  ImGui::SameLine();
  ask_button(s, Ask::kMakeCase, s.text("op.make_case"), {half, 0}, can);
  ImGui::BeginDisabled(!can);
  choice("##family", form.family, 0, static_cast<int>(form.families.size()),
         [&](int i) { return form.families[static_cast<std::size_t>(i)].second; });
  slider(s, "##difficulty", form.difficulty, 0, 1, s.text("op.difficulty"), 2, "", half);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(half);
  ImGui::InputScalar("##seed", ImGuiDataType_S32, &form.seed, nullptr, nullptr,
                     fmt::format("{} %d", s.text("op.seed")).c_str(), ImGuiInputTextFlags_AutoSelectAll);
  form.seed = std::max(form.seed, 0);
  ImGui::EndDisabled();
}

/// Choice of the contact model. Hidden unless a model other than the exercise's own is chosen.
void draw_model(OperatorState& s, InterfaceWindow& w, const SceneChoice& scene) {
  ImGui::Spacing();
  if (s.model >= 0) ImGui::SetNextItemOpen(true);
  if (!ImGui::CollapsingHeader(s.text("op.model"))) return;
  dim_wrapped(s.text("op.model_note"));
  const auto title = [&](int i) {
    return i < 0 ? fmt::format("{} ({})", s.text("op.model_of_exercise"), scene.model)
                 : s.models[static_cast<std::size_t>(i)];
  };
  const auto about = [&](int i) -> std::string {
    const std::string key = fmt::format("op.model.{}", i < 0 ? scene.model : s.models[static_cast<std::size_t>(i)]);
    // contact models from files outside of the program have no description in the text catalogue
    return session::has_text(key) ? s.text(key) : "";
  };
  choice("##model", s.model, -1, static_cast<int>(s.models.size()), title, -1, about);
  note(about(s.model), w);
}

void draw_details(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("details", s.text("op.goal"), size, w);
  if (s.selected_scene()) {
    const SceneChoice& scene = *s.selected_scene();
    draw_picture(s, w, scene.picture, ImGui::GetContentRegionAvail().x);
    ImGui::Spacing();
    ImGui::PushFont(w.style().large);
    wrapped(scene.title);
    ImGui::PopFont();
    if (scene.fault.empty())
      wrapped(scene.description);
    else
      colored_wrapped(scene.fault, kBad);
    draw_model(s, w, scene);
    if (scene.jaw) {
      ImGui::Spacing();
      ask_button(s, Ask::kPlan, s.text("op.plan_implant"), {-1, 0}, scene.fault.empty());
    }
  }
}

void draw_hands(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("hand", s.text("op.hand"), size, w);
  for (std::size_t i = 0; i < s.hands.size(); ++i) {
    const HandEntry& hand = s.hands[i];
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::RadioButton(hand.title.c_str(), static_cast<int>(i) == s.hand)) s.hand = static_cast<int>(i);
    if (!hand.detail.empty()) {
      ImGui::Indent(1.9f * w.style().unit);
      note(hand.detail, w, hand.usable ? kDim : kWarn);
      ImGui::Unindent(1.9f * w.style().unit);
    }
    ImGui::PopID();
  }
  if (key('H', true)) ImGui::SetKeyboardFocusHere();
  if (text_field("##address", s.text("op.address_hint"), s.address)) s.hand = static_cast<int>(s.hands.size()) - 1;
  if (ImGui::Button(s.text("op.rescan"))) s.ask(Ask::kRescan);
  if (!s.real_time_refused.empty()) {
    ImGui::Checkbox(s.text("op.accept_no_real_time"), &s.no_real_time);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", s.real_time_refused.c_str());
  }
}

void draw_rigs(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("picture", s.text("op.picture"), size, w);
  for (std::size_t i = 0; i < s.rigs.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::RadioButton(s.rigs[i].title.c_str(), static_cast<int>(i) == s.rig)) s.rig = static_cast<int>(i);
    ImGui::PopID();
  }
  const bool own_window =
      s.rig >= 0 && s.rig < static_cast<int>(s.rigs.size()) && !s.rigs[static_cast<std::size_t>(s.rig)].embedded;
  if (own_window) {
    const auto name = [&](int m) {
      return m < 0 ? std::string(s.text("op.window"))
                   : fmt::format("{} {}: {}", s.text("op.full_screen"), m + 1, s.monitors[static_cast<std::size_t>(m)]);
    };
    if (s.monitor >= static_cast<int>(s.monitors.size())) s.monitor = -1;
    choice("##monitor", s.monitor, -1, static_cast<int>(s.monitors.size()), name);
  }
}

void draw_trainee(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("trainee", s.text("op.trainee"), size, w);
  if (key('T', true)) ImGui::SetKeyboardFocusHere();
  ImGui::BeginDisabled(!s.school.student.empty());
  text_field("##trainee", s.text("op.trainee_hint"), s.trainee);
  ImGui::EndDisabled();
  if (s.school.set_up)
    ask_button(s, Ask::kSchool, s.text(s.school.student.empty() ? "op.school_sign_in" : "op.school"), {-1, 0});
  ImGui::BeginDisabled(s.author);
  ImGui::Checkbox(s.text("op.record_this"), &s.record);
  ImGui::EndDisabled();
  ImGui::Checkbox(s.text("op.author"), &s.author);
}

void draw_set_up(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  begin_column("set_up", size);
  const float trainee = 9.2f * w.style().unit + (s.school.set_up ? ImGui::GetFrameHeightWithSpacing() : 0);
  const float rest = ImGui::GetContentRegionAvail().y - trainee - 2 * ImGui::GetStyle().ItemSpacing.y;
  draw_hands(s, w, {0, 0.56f * rest});
  draw_rigs(s, w, {0, 0.44f * rest});
  draw_trainee(s, w, {0, trainee});
  ImGui::EndChild();
}

/// Handles keys that belong to no button or field.
void follow_keys(OperatorState& s) {
  const auto next = [](int chosen, std::size_t count) { return count ? (chosen + 1) % static_cast<int>(count) : 0; };
  if (key('D', true)) s.hand = next(s.hand, s.hands.size());
  if (key('P', true)) s.rig = next(s.rig, s.rigs.size());
  if (key('M', true)) s.monitor = next(s.monitor + 1, s.monitors.size() + 1) - 1;
  if (key('G', true)) s.model = next(s.model + 1, s.models.size() + 1) - 1;
  if (key('R', true)) s.record = !s.record;
  if (key('E', true)) s.author = !s.author;
  if (key('L', true)) {
    const int count = s.chinese ? 3 : 2;
    s.ask(Ask::kLanguage, (static_cast<int>(s.language) + 1) % count);
  }
}

void draw_first_run(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  const PagePanel panel("first_run", nullptr, {0, 4.9f * u}, w);
  wrapped(s.text("op.first_run"));
  const auto offer = [&](const char* text, Ask ask, const Shortcut& key) {
    if (main_button(fmt::format("  {}   {}  ", s.text(text), key.name).c_str(), {0, 0})) s.ask(ask);
  };
  offer("op.check_computer", Ask::kDoctor, shortcut(Ask::kDoctor));
  ImGui::SameLine();
  offer("op.start_tutorial", Ask::kTutorial, shortcut(Ask::kTutorial));
  ImGui::SameLine();
  if (ImGui::Button(s.text("op.not_now"))) s.first_run = false;
}

}  // namespace

void draw_start_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  begin_page(w);
  draw_header(s, w);
  ImGui::Dummy({0, 0.2f * u});
  if (s.first_run) draw_first_run(s, w);
  const float foot = 3.2f * u, gap = ImGui::GetStyle().ItemSpacing.x;
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const float height = room.y - foot - ImGui::GetStyle().ItemSpacing.y;
  const float side = std::max(0.29f * room.x, 17 * u), left = 0.34f * room.x;
  const float cases = 9.2f * u;
  begin_column("exercises", {left, height});
  draw_scenes(s, w, {0, height - cases - ImGui::GetStyle().ItemSpacing.y});
  draw_cases(s, w, {0, cases});
  ImGui::EndChild();
  ImGui::SameLine();
  draw_details(s, w, {room.x - left - side - 2 * gap, height});
  ImGui::SameLine();
  draw_set_up(s, w, {side, height});

  const ImVec2 button{13 * u, foot - 0.4f * u};
  begin_column("foot", {room.x - button.x - gap, foot - 0.4f * u});
  state_line(s, 0.5f * room.x);
  ImGui::EndChild();
  ImGui::SameLine();
  ask_button(s, Ask::kStart, s.text("op.start"), button, s.can_start(), true);
  follow_keys(s);
  page_shortcuts(s);
  end_page();
}

void draw_loading_page(OperatorState& s, InterfaceWindow& w) {
  begin_page(w);
  const float u = w.style().unit, bar = 20 * u, button = 9 * u;
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const auto in_the_middle = [&](float width) { ImGui::SetCursorPosX((room.x - width) / 2); };
  const std::string text = fmt::format("{} …", s.text("op.loading"));
  ImGui::PushFont(w.style().large);
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  ImGui::SetCursorPosY((room.y - size.y) / 2);
  in_the_middle(size.x);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopFont();
  in_the_middle(ImGui::CalcTextSize(s.scene_title.c_str()).x);
  dim(s.scene_title);
  in_the_middle(bar);
  ImGui::ProgressBar(s.busy ? static_cast<float>(s.busy_fraction) : 1, {bar, 0}, "");
  in_the_middle(button);
  const bool cancelled = ImGui::Button(s.text("op.cancel"), {button, 0});
  // The emergency keys also cancel.
  if (cancelled || ImGui::IsKeyPressed(display::keys::kEscape, false) || ImGui::IsKeyPressed(' ', false))
    s.ask(Ask::kCancel);
  if (key(display::keys::kF1)) s.help = true;
  end_page();
}

}  // namespace typodont
