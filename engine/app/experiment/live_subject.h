// A person as the subject of an experiment. The person feels the stimuli in a live session and answers by key. Only for
// the render thread.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/app/experiment/experiment.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"

namespace typodont {

/// Presents stimuli to a person. Stimuli with the same contact model share one session. For another model the session
/// is closed and a new one is opened. A stimulus changes only while the tool touches nothing, so that the change causes
/// no force step. The person answers in the session's window with the arrow keys left (first) and right (second), or on
/// standard input with "1" or "2" and Enter.
class LiveSubject {
 public:
  struct Options {
    WorkbenchOptions workbench;
    Question question = Question::kStiffness;
    double seconds = 4;     // s, duration of each stimulus
    double most_delay = 0;  // s, largest delay of the force among all stimuli
  };
  /// Stores the options. The first call of ask() opens a session. Throws Error.
  LiveSubject(const Scene& scene, const Options& options);
  ~LiveSubject();

  struct Given {
    Answer answer;
    double seconds;  // s, time from the question to the answer
  };
  /// Presents both stimuli and asks for the answer. Returns an empty optional if the session ended. `of`: text that
  /// states the number of the trial, for example "12 of at most 100".
  std::optional<Given> ask(const Trial& trial, const std::string& of);
  /// Ends the session. Throws RunFailure if the session failed.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
