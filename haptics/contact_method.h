// The methods of contact by name: what a scene's "model" and the option --model choose from.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "haptics/contact_model.h"
#include "haptics/tissue_body.h"
#include "haptics/tool.h"

namespace typodont::haptics {

struct ServoSettings;

/// A method with its parameters. Immutable; shared by servo and carver. Set-up functions throw Error.
class ContactMethod {
 public:
  virtual ~ContactMethod() = default;
  virtual std::string_view name() const = 0;
  /// Whether its bodies have triangles of their own for pictures (TissueBody::surface).
  virtual bool draws_own_surface() const { return false; }
  /// The servo's half. `settings` outlive it; they are complete (frame included).
  virtual std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const = 0;
  /// The carver's half. `tools` as Cut::tool numbers them.
  virtual std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const = 0;
};
using SharedContactMethod = std::shared_ptr<const ContactMethod>;

/// Reads a method's parameters: an object of the scene, or nothing where only its name was given. Throws Error.
using ContactMethodReader = std::function<SharedContactMethod(const std::optional<Json>& parameters)>;

/// Adds a method from outside this library. At namespace scope of any file of the program:
///   const ContactMethodRegistration registration{"mine", [](const auto& parameters) { … }};
/// A name that is taken throws std::logic_error.
struct ContactMethodRegistration {
  ContactMethodRegistration(std::string name, ContactMethodReader reader);
};

/// By name, with its default parameters. Throws Error, which names those there are; `where` is the file or option.
SharedContactMethod contact_method(std::string_view name, std::string_view where);
/// From a scene: "offset", or {"offset": {parameters}}. Throws Error.
SharedContactMethod read_contact_method(const Json& json);
/// What a method is called in full ("god-object" is an alias of "offset"); in the order in which they are listed to
/// users.
std::vector<std::string> contact_method_names();
/// These names as words for help and messages: "one of: offset, …".
std::string known_contact_methods();

/// How many servo's and carver's halves of a method were made in this process.
struct MethodCount {
  std::string name;
  std::uint64_t models = 0, bodies = 0;
};
/// All methods, in the order of contact_method_names(). Any thread.
std::vector<MethodCount> method_counts();

/// The one that is used where nothing is chosen: "offset".
const SharedContactMethod& default_contact_method();

}  // namespace typodont::haptics
