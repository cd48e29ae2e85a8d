// A person as the subject, who feels the stimuli in a live session and answers by key. Drawing thread.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/app/experiment/experiment.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"

namespace typodont {

/// Stimuli with the same contact model share one session; for another model the session is closed and a new one opened.
/// A stimulus changes only while the tool touches nothing, so that the change causes no force step. Answers are the
/// keys left (first) and right (second) in the session's window, or "1" or "2" and Enter on standard input.
class LiveSubject {
 public:
  struct Options {
    WorkbenchOptions workbench;
    Question question = Question::kStiffness;
    double seconds = 4;     // duration of each stimulus
    double most_delay = 0;  // s, longest delay of any stimulus
  };
  /// Throws Error.
  LiveSubject(const Scene& scene, const Options& options);
  ~LiveSubject();

  struct Given {
    Answer answer;
    double seconds;  // from the question to the answer
  };
  /// Shows both stimuli and asks. Returns no value if the session was ended instead. `of`: the number of the trial as
  /// text, as "12 of at most 100".
  std::optional<Given> ask(const Trial& trial, const std::string& of);
  /// Ends the session. Throws RunFailure if the session failed.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
