// A person as the subject: feels the stimuli in a live session and answers by key. Drawing thread.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "engine/app/experiment/experiment.h"
#include "engine/app/scene.h"
#include "engine/app/workbench.h"

namespace typodont {

/// One session shows all stimuli that have the same contact model; another model needs a session of its own, which is
/// opened in its place. A stimulus changes only while the tool touches nothing, so no change is felt as a step. Answers
/// come from the keys left (first) and right (second) of the session's window, or as "1" or "2" with Enter from
/// standard input.
class LiveSubject {
 public:
  struct Options {
    WorkbenchOptions workbench;
    Question question = Question::kStiffness;
    double seconds = 4;     // that each stimulus is felt
    double most_delay = 0;  // s, of any stimulus
  };
  /// Throws Error.
  LiveSubject(const Scene& scene, const Options& options);
  ~LiveSubject();

  struct Given {
    Answer answer;
    double seconds;  // from the question to the answer
  };
  /// Shows both stimuli and asks. Nothing: the session was ended instead. `of`: "12 of at most 100".
  std::optional<Given> ask(const Trial& trial, const std::string& of);
  /// Ends the session in order. Throws RunFailure when it failed.
  void stop();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont
