#include "api/convert/access.h"

#include <optional>
#include <utility>

#include "api/convert/enum_table.h"

namespace isthmus::convert {
namespace {

constexpr std::pair<AccessRole, v1::Role> kAccessRoles[] = {
    {AccessRole::kRobot, v1::ROLE_ROBOT},
    {AccessRole::kReader, v1::ROLE_READER},
    {AccessRole::kOperator, v1::ROLE_OPERATOR},
    {AccessRole::kAdmin, v1::ROLE_ADMIN},
};

}  // namespace

v1::Token ToMessage(const AccessToken& token) {
  v1::Token message;
  message.set_name(token.name);
  message.set_role(ToMessage(kAccessRoles, token.role));
  for (const std::string& robot : token.robots) message.add_robots(robot);
  for (const std::string& site : token.sites) message.add_sites(site);
  message.set_created_ns(token.created_ns);
  message.set_expires_ns(token.expires_ns);
  message.set_revoked_ns(token.revoked_ns);
  return message;
}

absl::StatusOr<AccessToken> FromMessage(const v1::Token& token) {
  const auto role = FromMessage(kAccessRoles, token.role(), std::optional<AccessRole>());
  if (!role) {
    return absl::InvalidArgumentError("give the token a role: robot, reader, operator or admin");
  }
  AccessToken record;
  record.name = token.name();
  record.role = *role;
  record.robots.assign(token.robots().begin(), token.robots().end());
  record.sites.assign(token.sites().begin(), token.sites().end());
  record.created_ns = token.created_ns();
  record.expires_ns = token.expires_ns();
  record.revoked_ns = token.revoked_ns();
  return record;
}

}  // namespace isthmus::convert
