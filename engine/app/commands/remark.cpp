// `typodont remark`: edits a teacher's remarks on a session, in a file beside the recording.
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/error.h"
#include "engine/session/remarks.h"
#include "engine/session/session_data.h"
#include "engine/session/session_file.h"

namespace typodont {

namespace {

struct RemarkOptions {
  std::string session, text, author;
  double at = -1;
  int edit = 0, remove = 0;
  bool json = false;
};

session::Remark& numbered(std::vector<session::Remark>& remarks, int number, const char* option) {
  if (number < 1 || static_cast<std::size_t>(number) > remarks.size())
    throw Error("", option, std::to_string(number), fmt::format("one of the {} remarks", remarks.size()));
  return remarks[static_cast<std::size_t>(number - 1)];
}

void run(const RemarkOptions& options) {
  const session::SessionReader session{std::filesystem::path(options.session)};
  std::vector<session::Remark> remarks = session::read_remarks(options.session);
  if (options.remove > 0) {
    numbered(remarks, options.remove, "--remove");
    remarks.erase(remarks.begin() + options.remove - 1);
  } else if (!options.text.empty()) {
    session::Remark* remark = options.edit > 0 ? &numbered(remarks, options.edit, "--edit") : &remarks.emplace_back();
    remark->text = options.text;
    remark->written = session::iso_date_now();
    if (!options.author.empty()) remark->author = options.author;
    if (options.at >= 0) remark->at = options.at;
  }
  if (options.remove > 0 || !options.text.empty()) session::write_remarks(options.session, remarks);
  if (options.json) {
    fmt::print("{}", session::remarks_text(remarks));
    return;
  }
  for (std::size_t i = 0; i < remarks.size(); ++i) {
    const session::Remark& remark = remarks[i];
    const std::string at = remark.at ? fmt::format(" at {:.1f} s", *remark.at) : "";
    fmt::print("{}{}: {} ({} {})\n", i + 1, at, remark.text, remark.author, remark.written);
  }
}

}  // namespace

void add_remark_command(cli::Command& app) {
  cli::Command* command = app.add_command("remark", "Write, change or list remarks on a recorded session");
  const auto options = std::make_shared<RemarkOptions>();
  command->add_option("SESSION", options->session, "A recorded session (.h5); SESSION.h5.remarks.json is beside it")
      ->required();
  command->add_option("--text", options->text, "The remark; without it and --remove, the remarks are listed");
  command->add_option("--author", options->author, "Who writes it");
  command->add_option("--at", options->at, "The moment of the recording, s", cli::range(0, 86'400));
  command->add_option("--edit", options->edit, "Change the remark of this number", cli::range(1, 100'000));
  command->add_option("--remove", options->remove, "Remove the remark of this number", cli::range(1, 100'000));
  command->add_flag("--json", options->json, "Print the remarks as JSON");
  command->footer("Example: typodont remark session.h5 --at 42.5 --text \"The bur leaned towards the buccal wall\"");
  command->callback([options, command] {
    command->refuse_without({"--author", "--at", "--edit"}, !options->text.empty(), "--text");
    command->refuse_without({"--text"}, options->remove == 0, "a remark that stays");
    run(*options);
  });
}

}  // namespace typodont
