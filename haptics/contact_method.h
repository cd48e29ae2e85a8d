// The contact methods by name: the values of a scene's "model" and of the option --model.
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

/// A contact method with its parameters. Immutable; shared by servo and carver. Set-up functions throw Error.
class ContactMethod {
 public:
  virtual ~ContactMethod() = default;
  virtual std::string_view name() const = 0;
  /// True if the method's bodies have their own triangles for pictures (TissueBody::surface).
  virtual bool draws_own_surface() const { return false; }
  /// Makes the part that runs on the servo thread. `settings` must outlive the model and be complete (frame included).
  virtual std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const = 0;
  /// Makes the part that runs on the carver thread. Cut::tool is an index into `tools`.
  virtual std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const = 0;
};
using SharedContactMethod = std::shared_ptr<const ContactMethod>;

/// Reads a method's parameters from an object of the scene; nullopt: only the name was given. Throws Error.
using ContactMethodReader = std::function<SharedContactMethod(const std::optional<Json>& parameters)>;

/// Registers a contact method that another module defines. Declare it at namespace scope in any file of the program:
///   const ContactMethodRegistration registration{"mine", [](const auto& parameters) { … }}; Throws std::logic_error
/// if the name already exists.
struct ContactMethodRegistration {
  ContactMethodRegistration(std::string name, ContactMethodReader reader);
};

/// The method with this name and default parameters. Throws Error with the list of names; `where`: the file or option.
SharedContactMethod contact_method(std::string_view name, std::string_view where);
/// Reads the method of a scene: "offset", or {"offset": {parameters}}. Throws Error.
SharedContactMethod read_contact_method(const Json& json);
/// The full names of all methods, in the order in which users see them. ("god-object" is an alias of "offset".)
std::vector<std::string> contact_method_names();
/// The list of names for help and messages: "one of: offset, …".
std::string known_contact_methods();

/// Numbers of models (servo's halves) and bodies (carver's halves) of one method that this process has made.
struct MethodCount {
  std::string name;
  std::uint64_t models = 0, bodies = 0;
};
/// A MethodCount for each method, in the order of contact_method_names(). Any thread.
std::vector<MethodCount> method_counts();

/// The method that is used if none is chosen: "offset".
const SharedContactMethod& default_contact_method();

}  // namespace typodont::haptics
