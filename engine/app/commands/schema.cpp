// `typodont schema`: the keys of scenes, rigs and other files, for editors and for the tables in docs/.
#include <fmt/format.h>

#include <map>
#include <memory>

#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/app/scene.h"
#include "engine/app/scene/handpiece_file.h"
#include "engine/app/scene/implant_scene.h"
#include "engine/app/tissue/paint_file.h"
#include "engine/app/tissue/row.h"
#include "engine/app/tissue/tooth_form.h"
#include "engine/base/keys.h"
#include "engine/display/display_rig.h"
#include "haptics/described.h"
#include "haptics/scripted_hand.h"

namespace typodont {

namespace {

/// Lists the keys of T.
template <auto describe, class T>
void list_kinds(Keys& keys) {
  T value{};
  describe(keys, value);
}

void list_suction_tip(Keys& keys) {
  SuctionTip tip;
  debris::Suction suction;
  describe_suction_tip(keys, tip, suction);
}

void list_procedure(Keys& keys) {
  session::ImplantTask task;
  describe_procedure(keys, task, {});
}

const std::map<std::string, void (*)(Keys&)> kSchemas = {
    {"scene", list_kinds<describe_scene, Scene>},
    {"tool", list_kinds<haptics::describe_tool, haptics::Tool>},
    {"motor", list_kinds<haptics::describe_spindle, haptics::Spindle>},
    {"handpiece", list_kinds<describe_handpiece, Handpiece>},
    {"suction", list_suction_tip},
    {"procedure", list_procedure},
    {"paint", list_kinds<describe_paint_file, std::vector<PaintStroke>>},
    {"row", list_kinds<describe_tooth_row, ToothRow>},
    {"tooth", list_kinds<describe_tooth_form, ToothForm>},
    {"rig", list_kinds<display::describe_rig, display::DisplayRig>},
    {"arm", haptics::list_arm},
    {"hand", list_kinds<haptics::describe_hand, haptics::HandModel>}};

struct SchemaOptions {
  std::string kind = "scene";
  bool tables = false;
};

void run(const SchemaOptions& options) {
  std::vector<KeyRow> rows;
  Keys keys(rows);
  kSchemas.at(options.kind)(keys);
  fmt::print("{}\n", options.tables ? key_tables(options.kind, rows) : key_schema(rows));
}

}  // namespace

void add_schema_command(cli::Command& app) {
  auto options = std::make_shared<SchemaOptions>();
  cli::Command* command = app.add_command("schema", "Print the keys of scenes and other files, for editors");
  command->footer("Example:\n  typodont schema scene > scene.schema.json");
  std::vector<std::string> names;
  for (const auto& [name, describe] : kSchemas) names.push_back(name);
  command->add_option("kind", options->kind, "kind of the file", cli::one_of(names));
  command->add_flag("--tables", options->tables, "print the tables of the documentation, not a JSON Schema");
  command->callback([options] { run(*options); });
}

}  // namespace typodont
