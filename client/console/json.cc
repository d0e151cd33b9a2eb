#include "client/console/json.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <iostream>
#include <vector>

#include "api/convert/geometry.h"
#include "api/convert/graph.h"

namespace isthmus::cli {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

void UnquoteAll(const Descriptor& type, Json& object);

// protobuf's mapping has integers of 64 bits as text, which scripts would compare letter by letter.
void Unquote(const FieldDescriptor& field, Json& value) {
  if (field.message_type() != nullptr) return UnquoteAll(*field.message_type(), value);
  if (field.type() != FieldDescriptor::TYPE_INT64 && field.type() != FieldDescriptor::TYPE_UINT64) {
    return;
  }
  value = Json::parse(value.get_ref<const std::string&>(), nullptr, /*allow_exceptions=*/false);
}

void UnquoteAll(const Descriptor& type, Json& object) {
  for (const auto& item : object.items()) {
    const FieldDescriptor& field = *type.FindFieldByName(item.key());
    if (!field.is_repeated()) {
      Unquote(field, item.value());
      continue;
    }
    for (Json& one : item.value()) Unquote(field, one);
  }
}

template <typename Message>
Message WithEdges(Message message, const std::vector<SubmapEdge>& edges) {
  for (const SubmapEdge& edge : edges) *message.add_edges() = convert::ToMessage(edge);
  return message;
}

}  // namespace

Json ToJson(const google::protobuf::Message& message) {
  google::protobuf::util::JsonPrintOptions options;
  options.always_print_primitive_fields = true;
  options.preserve_proto_field_names = true;
  std::string text;
  if (!google::protobuf::util::MessageToJsonString(message, &text, options).ok()) return nullptr;
  Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return nullptr;
  UnquoteAll(*message.GetDescriptor(), json);
  return json;
}

Json ToJson(const Pose& pose) { return ToJson(convert::ToMessage(pose)); }

Json ToJson(const MatchEdge& edge) {
  return ToJson(WithEdges(convert::ToMessage(edge), edge.match.edges));
}

Json ToJson(const Loop& loop) {
  return ToJson(WithEdges(convert::ToMessage(loop), loop.loop.edges));
}

Json ToJson(const MatchGraph& graph) {
  Json out = {
      {"revision", graph.revision}, {"matches", Json::array()}, {"placements", Json::array()}};
  for (const MatchEdge& edge : graph.matches) out["matches"].push_back(ToJson(edge));
  for (const PlacedSession& placed : graph.placements) {
    out["placements"].push_back(ToJson(convert::ToMessage(placed)));
  }
  return out;
}

Json Versioned(const Json& document) {
  Json out = {{"version", kJsonVersion}};
  out.update(document);
  return out;
}

namespace {

// Names and notes come from others: what is not UTF-8 is replaced rather than refused, and ASCII
// alone has nothing that a terminal obeys.
std::string Dump(const Json& document, int indent) {
  return Versioned(document).dump(indent, ' ', true, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string Text(const Json& document) { return Dump(document, 2); }

void Print(const Json& document) { std::cout << Text(document); }
void PrintLine(const Json& document) { std::cout << Dump(document, -1); }

}  // namespace isthmus::cli
