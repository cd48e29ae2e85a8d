// The page of experiments: choice of the question, trials, result.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/app/operator/widgets.h"

namespace typodont {

namespace {

using namespace widgets;

void draw_question(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  ExperimentForm& form = s.experiment;
  const PagePanel panel("question", s.text("op.experiment_question"), size, w);
  constexpr int kCount = static_cast<int>(kExperimentQuestions.size());
  if (key('U', true)) form.question = (form.question + 1) % kCount;
  for (int i = 0; i < kCount; ++i) {
    const std::string name = kExperimentQuestions[static_cast<std::size_t>(i)];
    if (ImGui::RadioButton(s.text("op.experiment." + name), i == form.question)) form.question = i;
  }
  const auto question = static_cast<std::size_t>(form.question);
  note(s.text(fmt::format("op.experiment_help.{}", kExperimentQuestions[question])), w);
  if (question == kModelQuestion) {
    const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
    for (std::size_t side = 0; side < form.models.size(); ++side) {
      if (side > 0) ImGui::SameLine();
      choice(
          side == 0 ? "##first" : "##second", form.models[side], 0, static_cast<int>(s.models.size()),
          [&](int i) { return s.models[static_cast<std::size_t>(i)]; }, half);
    }
  }
  ImGui::Spacing();
  if (key('T', true)) ImGui::SetKeyboardFocusHere();
  text_field("##person", s.text("op.experiment_person"), s.trainee);
  const auto number = [&](auto& value, auto least, auto most, ImGuiDataType type, const std::string& format,
                          const char* id) {
    ImGui::SetNextItemWidth(-1);
    ImGui::InputScalar(id, type, &value, nullptr, nullptr, format.c_str(), ImGuiInputTextFlags_AutoSelectAll);
    value = std::clamp(value, least, most);
  };
  const char* trials = s.text(question == kModelQuestion ? "op.experiment_trials" : "op.experiment_most_trials");
  number(form.trials[question], 1, 10000, ImGuiDataType_S32, fmt::format("%d {}", trials), "##trials");
  number(form.seconds, 0.05f, 600.0f, ImGuiDataType_Float, fmt::format("%.4g {}", s.text("op.experiment_seconds")),
         "##seconds");
}

/// Shows which exercise, hand (device) and display the start page has selected, because the experiment uses them.
void draw_selection(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("selection", s.text("op.experiment_with"), size, w);
  const auto title = [](const auto& list, int chosen) {
    return chosen >= 0 && chosen < static_cast<int>(list.size()) ? list[static_cast<std::size_t>(chosen)].title : "–";
  };
  row(s.text("op.exercise"), title(s.scenes, s.scene));
  row(s.text("op.hand"), title(s.hands, s.hand));
  row(s.text("op.picture"), title(s.rigs, s.rig));
  ImGui::Spacing();
  dim_wrapped(s.text("op.experiment_course"));
}

/// A value with its 95 % confidence interval, for example "12 (95 %: 8 to 19) %".
std::string interval_text(const OperatorState& s, const FoundValue& found, const char* unit) {
  const auto number = [&](double v) {
    return std::isnan(v) ? std::string("–") : s.number(v, std::abs(v) < 10 ? 1 : 0);
  };
  return s.words("op.experiment_interval", number(found.value), number(found.low), number(found.high), unit);
}

void draw_finding(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("finding", s.text("op.result"), size, w);
  if (const auto& found = s.experiment_found) {
    const std::string question = kExperimentQuestions[found->question];
    row(s.text("op.experiment_question"), s.text("op.experiment." + question));
    row(s.text("op.experiment_person_short"), found->person.empty() ? "–" : found->person);
    row(s.text("op.experiment_answered"), fmt::format("{}", found->trials));
    if (found->question == kModelQuestion) {
      row(s.words("op.experiment_chose", found->models[1], found->models[0]).c_str(),
          interval_text(s, found->found, "%"));
      row(s.text("op.experiment_chance"), s.number(found->chance, 3));
    } else {
      row(s.text("op.experiment_right"), s.number(found->right, 0) + " %");
      row(s.text("op.experiment_jnd"), interval_text(s, found->found, question == "delay" ? "ms" : "%"));
    }
    ImGui::Spacing();
    ask_button(s, Ask::kOpenReport, s.text("op.experiment_open"), {-1, 0}, !s.busy);
  } else {
    dim_wrapped(s.text("op.experiment_none"));
  }
}

}  // namespace

void draw_experiment_page(OperatorState& s, InterfaceWindow& w) {
  const ImVec2 body = begin_titled_page(s.text("op.experiment"), w), gap = ImGui::GetStyle().ItemSpacing;
  const float height = body.y, side = 0.5f * (body.x - gap.x);
  ImGui::BeginDisabled(s.busy);
  draw_question(s, w, {side, height});
  ImGui::EndDisabled();
  ImGui::SameLine();
  begin_column("side", {side, height});
  draw_selection(s, w, {0, 0.5f * (height - gap.y)});
  draw_finding(s, w, {0, 0.5f * (height - gap.y)});
  ImGui::EndChild();
  end_titled_page(s, w, !s.busy, [&](ImVec2 button) {
    const ExperimentForm& form = s.experiment;
    const bool two = static_cast<std::size_t>(form.question) != kModelQuestion || form.models[0] != form.models[1];
    ask_button(s, Ask::kStart, s.text("op.experiment_start"), button, s.can_start() && two && !s.busy, true);
  });
}

}  // namespace typodont
