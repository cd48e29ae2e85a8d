#include "engine/app/operator/school_desk.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/app/assets.h"
#include "engine/app/operator/child.h"
#include "engine/app/operator/library.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/own_file.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

constexpr double kAnnouncements = 10;  // s between two announcements of an exam
constexpr int kLowPriority = 10;       // nice; the servo goes first, and the person does not wait long

fs::path sessions_folder() {
  return user_folder() / "sessions";
}

/// The program that speaks with the service: in the source tree, or installed beside the assets.
std::vector<std::string> school_program() {
  const fs::path beside = assets_folder().parent_path(), file = "typodont_school/hand_in.py";
  std::error_code code;
  const fs::path tree = beside / "engine/school" / file;
  return {"python3", (fs::exists(tree, code) ? tree : beside / "school" / file).string(), "window"};
}

/// The text of a stage that the program names.
const char* stage_text(std::string_view line) {
  if (line.find("\"sending\"") != std::string_view::npos) return "op.school_sending";
  if (line.find("\"checking\"") != std::string_view::npos) return "op.school_checking";
  return nullptr;
}

}  // namespace

SchoolDesk::SchoolDesk(OperatorState& s, InterfaceWindow& w, Choices& choices) : s_(s), window_(w), choices_(choices) {
  const char* set = std::getenv("TYPODONT_SCHOOL_TOKEN_FILE");
  std::error_code code;
  s_.school.set_up = fs::exists(set && *set ? fs::path(set) : user_folder() / "school.token", code);
  if (s_.school.set_up && fs::exists(sessions_folder(), code))
    ask(Kind::kSendWanted,
        {{"do", "send_wanted"}, {"folder", sessions_folder().string()}, {"program", own_file().string()}});
}

void SchoolDesk::ask(Kind kind, const nlohmann::json& question) {
  questions_.push_back({kind, question.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)});
  s_.school.busy = true;
  if (is_shown(kind)) say(s_.text(kind == Kind::kHandIn ? "op.school_sending" : "op.school_asking"));
}

void SchoolDesk::sign_in() {
  SchoolForm& form = s_.school;
  ask(Kind::kSignIn, {{"do", "sign_in"}, {"name", form.name.data()}, {"password", form.password.data()}});
  form.password.fill(0);
}

void SchoolDesk::sign_out() {
  token_.clear();
  s_.school.student.clear();
  s_.school.curves.clear();
  s_.school.assignments.clear();
  s_.trainee.fill(0);
  say("");
}

void SchoolDesk::refresh() {
  if (s_.school.student.empty()) return;
  ask(Kind::kRefresh, {{"do", "me"}, {"token", token_}, {"language", session::tag_of(s_.language)}});
}

void SchoolDesk::take() {
  const auto i = static_cast<std::size_t>(s_.school.assignment);
  if (i >= s_.school.assignments.size()) return;
  const SchoolForm::Assignment& chosen = s_.school.assignments[i];
  if (!chosen.files) {
    for (const SceneChoice& scene : s_.scenes)
      if (!scene.own && scene.name == chosen.scene) return select(scene.file);
    return fail("not_open");
  }
  ask(Kind::kTake, {{"do", "take"},
                    {"token", token_},
                    {"student", s_.school.student},
                    {"language", session::tag_of(s_.language)},
                    {"number", chosen.number},
                    {"sealed", chosen.sealed},
                    {"folder", (user_folder() / "scenes").string()}});
}

void SchoolDesk::announce(double seconds) {
  announced_ = seconds;
  ask(Kind::kAnnounce, {{"do", "announce"}, {"exam", s_.exam}, {"seconds", seconds}});
}

void SchoolDesk::hand_in(const fs::path& recording) {
  say("");
  if (!s_.exam.empty() && s_.school.set_up) announce(s_.outcome.summary.seconds);
  if (recording.empty() || s_.school.student.empty() || !s_.school.hand_in) return;
  // Until the server has the recording, this file stays. So it is sent also if the window ends before.
  std::ofstream(recording.string() + ".to-hand-in");
  ask(Kind::kHandIn, {{"do", "hand_in"},
                      {"folder", sessions_folder().string()},
                      {"file", recording.string()},
                      {"program", own_file().string()}});
}

void SchoolDesk::begin() {
  Question next = std::move(questions_.front());
  questions_.pop_front();
  kind_ = next.kind;
  stage_ = "";
  job_.make(
      [input = std::move(next.json)](Progress& progress) {
        progress.stage("op.school_asking");
        return run_program(school_program(), progress,
                           {.nice = kLowPriority, .input = input, .on_line = [&](std::string_view line) {
                              if (const char* stage = stage_text(line)) progress.stage(stage);
                            }});
      },
      [this](const std::string& output) { take_answer(output); });
}

bool SchoolDesk::look() {
  if (!job_.under_way()) {
    if (s_.page == Page::kSession && !s_.exam.empty() && s_.school.set_up && questions_.empty()) {
      const double seconds = s_.status.seconds;
      if (seconds < announced_) announced_ = 0;  // another session
      if (seconds >= announced_ + kAnnouncements) announce(seconds);
    }
    if (questions_.empty()) return false;
    begin();
    return true;
  }
  if (!job_.done()) {
    const char* stage = job_.progress()->what();
    if (std::exchange(stage_, stage) == stage || *stage == 0) return false;
    if (is_shown(kind_)) say(s_.text(stage));
    return true;
  }
  s_.school.busy = !questions_.empty();
  if (is_shown(kind_)) say("");
  try {
    job_.look();
  } catch (const NotStarted&) {
    fail("no_python");
  } catch (const std::exception& e) {
    fail("failed", e.what());
  }
  return true;
}

void SchoolDesk::take_answer(const std::string& output) {
  const Json answer = Json::parse(last_line(output), "school", Json::Lines::kUnknown);
  SchoolForm& form = s_.school;
  if (kind_ == Kind::kAnnounce) return;  // an exam goes on without the service
  if (answer.has("error")) {
    const std::string code = answer["error"].string();
    if (code == "expired") sign_out();
    return fail(code, answer.string_or("detail", ""));
  }
  switch (kind_) {
    case Kind::kSignIn:
      token_ = answer["token"].string();
      form.student = answer["student"].string();
      s_.trainee.fill(0);
      form.student.copy(s_.trainee.data(), s_.trainee.size() - 1);
      log::info("signed in at the school");
      refresh();
      break;
    case Kind::kRefresh: {
      std::string texts;
      form.curves.clear();
      for (const Json& curve : answer["curves"].items()) {
        form.curves.push_back({curve["title"].string(), {}});
        for (const Json& points : curve["points"].items())
          form.curves.back().points.push_back(static_cast<float>(points.number(0, 100)));
        texts += form.curves.back().title;
      }
      form.assignments.clear();
      for (const Json& one : answer["assignments"].items()) {
        form.assignments.push_back({static_cast<int>(one["number"].integer(0, 1 << 30)), one["title"].string(),
                                    one["due"].string(), one["scene"].string(),
                                    static_cast<int>(one["left"].integer(0, 1000)), one["sealed"].boolean(),
                                    one["files"].boolean()});
        texts += form.assignments.back().title;
      }
      // The next assignment with attempts left is selected.
      const auto next = std::find_if(form.assignments.begin(), form.assignments.end(),
                                     [](const SchoolForm::Assignment& one) { return one.left > 0; });
      form.assignment = next == form.assignments.end() ? 0 : static_cast<int>(next - form.assignments.begin());
      window_.announce_text(texts);
      log::info("open assignments: {}", form.assignments.size());
      break;
    }
    case Kind::kTake:
      choices_.rescan();
      select(answer["scene"].string());
      break;
    case Kind::kAnnounce:
      break;
    case Kind::kHandIn: {
      const std::string state = answer["state"].string();
      say(s_.text(state == "accepted"  ? "op.school_accepted"
                  : state == "refused" ? "op.school_refused"
                                       : "op.school_waiting"),
          state == "refused");
      log::info("handed in: {}", state);
      refresh();
      break;
    }
    case Kind::kSendWanted:
      if (const auto sent = answer["sent"].integer(0); sent > 0) {
        say(s_.words("op.school_sent", sent));
        log::info("handed in: {} of an earlier time", sent);
      }
      break;
  }
}

void SchoolDesk::select(const fs::path& file) {
  choices_.choose_scene(file);
  if (s_.page == Page::kSchool) s_.page = Page::kStart;
  s_.say(s_.words("op.school_taken", s_.scenes.at(static_cast<std::size_t>(s_.scene)).title));
  log::info("exercise selected: {}", file.string());
}

void SchoolDesk::say(const std::string& text, bool error) {
  s_.school.message = {text, error};
}

void SchoolDesk::fail(std::string_view code, const std::string& detail) {
  const std::string key = fmt::format("op.school_error.{}", code);
  const bool waits = code == "later";
  say(session::has_text(key) ? s_.words(key, detail) : s_.words("op.school_error.failed", code), !waits);
  log::info("school: {} {}", code, detail);
}

}  // namespace typodont
