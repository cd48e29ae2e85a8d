// Asks the school's service, one request at a time, by the program hand_in.py (engine/school). Main thread only.
#pragma once

#include <deque>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "engine/app/operator/choices.h"
#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"

namespace typodont {

class SchoolDesk {
 public:
  /// Without a bench's token on this computer, nothing is ever asked. Otherwise, sends recordings that an earlier
  /// window could not send.
  SchoolDesk(OperatorState& s, InterfaceWindow& w, Choices& choices);

  void sign_in();  // by the form, whose password is erased
  void sign_out();
  void refresh();  // scores and assignments of the signed-in student
  void take();     // the selected assignment
  /// Hands in a signed-in student's recording, if the student wishes it. Empty: there is none.
  void hand_in(const std::filesystem::path& recording);

  /// Begins and ends requests; during an exam, announces its recorded time. True: a frame must be drawn.
  bool look();

 private:
  enum class Kind { kSignIn, kRefresh, kTake, kAnnounce, kHandIn, kSendWanted };
  struct Question {
    Kind kind;
    std::string json;
  };
  void ask(Kind kind, const nlohmann::json& question);
  /// True: the user made the request, so its stages are shown.
  static bool is_shown(Kind kind) { return kind == Kind::kSignIn || kind == Kind::kTake || kind == Kind::kHandIn; }
  /// Tells the service how much of the exam is recorded, so that nobody can remove the end later.
  void announce(double seconds);
  void begin();
  void take_answer(const std::string& output);
  void select(const std::filesystem::path& file);
  void say(const std::string& text, bool error = false);
  void fail(std::string_view code, const std::string& detail = "");

  OperatorState& s_;
  InterfaceWindow& window_;
  Choices& choices_;
  std::string token_;     // of the signed-in student
  double announced_ = 0;  // s, recorded time of the exam at the last announcement
  std::deque<Question> questions_;
  Kind kind_{};             // of the request under way
  const char* stage_ = "";  // stage that the page shows
  Job job_;
};

}  // namespace typodont
