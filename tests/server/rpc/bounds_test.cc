// Every field of every request of the API: its limit, and that more is refused.
#include "api/convert/bounds.h"

#include <google/protobuf/descriptor.h>

#include <filesystem>
#include <memory>
#include <set>
#include <string>

#include "tests/server/rpc/rpc_fixture.h"

namespace isthmus::rpc {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::DescriptorPool;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::MessageFactory;

void AddWithParts(const Descriptor* type, std::set<const Descriptor*>* types) {
  if (!types->insert(type).second) return;
  for (int i = 0; i < type->field_count(); ++i) {
    const Descriptor* part = type->field(i)->message_type();
    if (part != nullptr) AddWithParts(part, types);
  }
}

// The requests of all methods, and what they are made of.
std::set<const Descriptor*> RequestTypes() {
  std::set<const Descriptor*> types;
  const std::filesystem::path folder(ISTHMUS_API_FOLDER);
  for (const auto& entry : std::filesystem::directory_iterator(folder / "isthmus/v1")) {
    if (entry.path().extension() != ".proto") continue;
    const std::string name = "isthmus/v1/" + entry.path().filename().string();
    const auto* file = DescriptorPool::generated_pool()->FindFileByName(name);
    EXPECT_NE(file, nullptr) << name;
    for (int s = 0; file != nullptr && s < file->service_count(); ++s) {
      for (int m = 0; m < file->service(s)->method_count(); ++m) {
        AddWithParts(file->service(s)->method(m)->input_type(), &types);
      }
    }
  }
  EXPECT_GT(types.size(), 40u);
  return types;
}

bool IsText(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_STRING;
}

std::set<const FieldDescriptor*> Fields() {
  std::set<const FieldDescriptor*> fields;
  for (const Descriptor* type : RequestTypes()) {
    for (int i = 0; i < type->field_count(); ++i) {
      const FieldDescriptor* field = type->field(i);
      if (field->is_repeated() || IsText(*field)) fields.insert(field);
    }
  }
  return fields;
}

void AddValue(const FieldDescriptor& field, size_t length, Message* message) {
  const auto* in = message->GetReflection();
  const std::string text(length, 'x');
  if (!field.is_repeated()) return in->SetString(message, &field, text);
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_STRING:
      return in->AddString(message, &field, text);
    case FieldDescriptor::CPPTYPE_ENUM:
      return in->AddEnumValue(message, &field, 0);
    case FieldDescriptor::CPPTYPE_MESSAGE:
      in->AddMessage(message, &field);
      return;
    default:
      FAIL() << field.full_name() << ": say here how to add one";
  }
}

absl::Status Check(const FieldDescriptor& field, size_t values, size_t length) {
  const std::unique_ptr<Message> message(
      MessageFactory::generated_factory()->GetPrototype(field.containing_type())->New());
  for (size_t i = 0; i < values; ++i) AddValue(field, length, message.get());
  return convert::CheckBounds(*message);
}

TEST(BoundsTest, EveryStringAndListOfARequestHasOne) {
  for (const FieldDescriptor* field : Fields()) {
    const convert::FieldBound bound = convert::BoundOf(*field);
    EXPECT_EQ(bound.values > 0, field->is_repeated()) << field->full_name();
    EXPECT_EQ(bound.length > 0, IsText(*field)) << field->full_name();
  }
}

TEST(BoundsTest, OnlyPointsAreAsLongAsAMessage) {
  for (const FieldDescriptor* field : Fields()) {
    if (convert::BoundOf(*field).length != convert::kAsTheMessage) continue;
    EXPECT_EQ(field->name(), "data");
    EXPECT_EQ(field->type(), FieldDescriptor::TYPE_BYTES);
  }
}

TEST(BoundsTest, WhatIsMoreIsRefused) {
  for (const FieldDescriptor* field : Fields()) {
    const convert::FieldBound bound = convert::BoundOf(*field);
    if (bound.length == convert::kAsTheMessage) continue;
    const size_t values = field->is_repeated() ? bound.values : 1;
    EXPECT_TRUE(Check(*field, values, bound.length).ok()) << field->full_name();
    const auto refused = [&](const absl::Status& status) {
      return absl::IsInvalidArgument(status) &&
             status.message().find(field->name()) != std::string::npos;
    };
    if (field->is_repeated()) {
      EXPECT_TRUE(refused(Check(*field, values + 1, 1))) << field->full_name();
    }
    if (IsText(*field)) {
      EXPECT_TRUE(refused(Check(*field, 1, bound.length + 1))) << field->full_name();
    }
  }
}

TEST(BoundsTest, ASegmentOfTheLongestNamedRobotMayBeAskedFor) {
  const std::string longest = std::string(64, 'x') + "-1000000000.1000";
  v1::GetTrajectoryRequest by_robot;
  by_robot.set_robot(longest);
  EXPECT_TRUE(convert::CheckBounds(by_robot).ok());
  v1::GetSessionRequest by_session;
  by_session.set_session(longest);
  EXPECT_TRUE(convert::CheckBounds(by_session).ok());
}

TEST(BoundsTest, WhatIsWithinAMessageIsAskedToo) {
  v1::PutAnchorRequest request;
  request.mutable_anchor()->set_note(std::string(1001, 'x'));
  EXPECT_EQ(convert::CheckBounds(request).message(),
            "Anchor.note has 1001 characters: give at most 1000");
}

TEST(BoundsTest, SecretsOfTokensAreNoText) {
  const std::string secret = "isthmus_" + std::string(43, 'x');
  v1::PutAnchorRequest request;
  request.mutable_anchor()->set_note("by " + secret);
  const absl::Status refused = convert::CheckBounds(request);
  EXPECT_TRUE(absl::IsInvalidArgument(refused)) << refused;
  EXPECT_EQ(refused.message().find(secret), std::string::npos) << refused;
  request.mutable_anchor()->set_note("by isthmus_alice");
  EXPECT_TRUE(convert::CheckBounds(request).ok());
  v1::CreateTokenRequest token;
  token.mutable_token()->set_name(secret);
  EXPECT_FALSE(convert::CheckBounds(token).ok());
}

using BoundsRpcTest = RpcTest;

TEST_F(BoundsRpcTest, ASensorsNameOfMegabytesIsRefusedAndTheListsStayShort) {
  v1::CreateSessionRequest request;
  request.set_robot("alice");
  request.set_sensor("vlp16" + std::string(5'000'000, '-'));
  v1::Session session;
  EXPECT_GRPC_ERROR(stubs_->sessions->CreateSession(NewContext().get(), request, &session),
                    INVALID_ARGUMENT, "CreateSessionRequest.sensor has 5000005 characters");
  EXPECT_TRUE(pipeline_.sessions().List().empty());
}

TEST_F(BoundsRpcTest, AFirstMessageOfAStreamIsAskedToo) {
  const auto context = NewContext();
  const auto stream = stubs_->sessions->StreamScans(context.get());
  v1::StreamScansRequest request;
  request.set_session(std::string(1'000'000, 'x'));
  stream->Write(request);
  v1::StreamScansResponse ack;
  EXPECT_FALSE(stream->Read(&ack));
  EXPECT_GRPC_ERROR(stream->Finish(), INVALID_ARGUMENT, "StreamScansRequest.session");
}

}  // namespace
}  // namespace isthmus::rpc
