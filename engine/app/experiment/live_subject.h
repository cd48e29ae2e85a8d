// A person as the subject, who feels the stimuli in a live session and answers by key. Render thread only.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/app/experiment/experiment.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"

namespace typodont {

/// Stimuli with the same contact model share one session. A stimulus changes only while the tool touches nothing, so
/// that the force does not jump. Answers: left arrow (first), right arrow (second), or "1" and "2" on standard input.
class LiveSubject {
 public:
  struct Options {
    WorkbenchOptions workbench;
    Question question = Question::kStiffness;
    double seconds = 4;    // s, duration of each stimulus
    double max_delay = 0;  // s, largest delay among the stimuli
  };
  /// Prepares trials; the first ask() opens a session. Throws Error.
  LiveSubject(const Scene& scene, const Options& options);
  ~LiveSubject();

  struct Given {
    Answer answer;
    double seconds;  // s, time from the question to the answer
  };
  /// Presents both stimuli, then asks. Empty if the session ended. `of`: progress for the user, for example "12 of at
  /// most 100".
  std::optional<Given> ask(const Trial& trial, const std::string& of);
  /// Ends the session. Throws RunFailure if the session failed.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
