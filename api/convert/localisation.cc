#include "api/convert/localisation.h"

#include <utility>

#include "api/convert/enum_table.h"
#include "api/convert/geometry.h"
#include "api/convert/session.h"

namespace isthmus::convert {
namespace {

constexpr std::pair<LocalisationState, v1::LocaliseResponse::State> kLocalisationStates[] = {
    {LocalisationState::kSearching, v1::LocaliseResponse::SEARCHING},
    {LocalisationState::kAmbiguous, v1::LocaliseResponse::AMBIGUOUS},
    {LocalisationState::kLocated, v1::LocaliseResponse::LOCATED},
    {LocalisationState::kUncertain, v1::LocaliseResponse::UNCERTAIN},
};

}  // namespace

v1::LocaliseBegin ToMessage(const LocalisationRequest& request) {
  v1::LocaliseBegin message;
  message.set_sensor(request.sensor);
  *message.mutable_t_base_sensor() = ToMessage(request.T_base_sensor);
  message.set_odometry(ToMessage(request.odometry));
  message.set_robot(request.robot.value());
  message.set_in_map_of(request.in_map_of.value());
  return message;
}

absl::StatusOr<LocalisationRequest> FromMessage(const v1::LocaliseBegin& begin) {
  LocalisationRequest request;
  request.sensor = begin.sensor();
  request.robot = RobotId(begin.robot());
  request.in_map_of = RobotId(begin.in_map_of());
  const auto odometry = Checked(begin.odometry());
  if (!odometry.ok()) return odometry.status();
  request.odometry = *odometry;
  if (begin.has_t_base_sensor()) {
    const auto pose = Checked(begin.t_base_sensor(), "t_base_sensor");
    if (!pose.ok()) return pose.status();
    request.T_base_sensor = *pose;
  }
  return request;
}

v1::LocaliseResponse ToMessage(const LocalisedScan& scan) {
  v1::LocaliseResponse message;
  message.set_sequence(scan.sequence);
  message.set_state(ToMessage(kLocalisationStates, scan.state));
  message.set_rejected(scan.rejected);
  if (scan.T_map_sensor) *message.mutable_t_map_sensor() = ToMessage(*scan.T_map_sensor);
  if (scan.covariance) AddUpperTriangle(*scan.covariance, message.mutable_covariance());
  if (scan.T_map_odom) *message.mutable_t_map_odom() = ToMessage(*scan.T_map_odom);
  if (scan.T_odom_sensor) *message.mutable_t_odom_sensor() = ToMessage(*scan.T_odom_sensor);
  message.set_tracking(ToMessage(scan.tracking));
  message.set_segment(scan.segment);
  message.set_revision(scan.revision);
  message.set_component(scan.component);
  message.set_odometry_ms(scan.odometry_ms);
  message.set_localising_ms(scan.localising_ms);
  return message;
}

LocalisedScan FromMessage(const v1::LocaliseResponse& response) {
  LocalisedScan scan;
  scan.sequence = response.sequence();
  scan.state = FromMessage(kLocalisationStates, response.state(), LocalisationState::kSearching);
  scan.rejected = response.rejected();
  if (response.has_t_map_sensor()) scan.T_map_sensor = FromMessage(response.t_map_sensor());
  scan.covariance = FromUpperTriangle(response.covariance());
  if (response.has_t_map_odom()) scan.T_map_odom = FromMessage(response.t_map_odom());
  if (response.has_t_odom_sensor()) scan.T_odom_sensor = FromMessage(response.t_odom_sensor());
  scan.tracking = FromMessage(response.tracking());
  scan.segment = response.segment();
  scan.revision = response.revision();
  scan.component = response.component();
  scan.odometry_ms = response.odometry_ms();
  scan.localising_ms = response.localising_ms();
  return scan;
}

v1::Localising ToMessage(const Localising& localising) {
  v1::Localising message;
  message.set_state(ToMessage(kLocalisationStates, localising.state));
  message.set_tracking(ToMessage(localising.tracking));
  message.set_since_ns(localising.since_ns);
  message.set_received_ns(localising.received_ns);
  message.set_scans(localising.scans);
  message.set_rejected(localising.rejected);
  return message;
}

Localising FromMessage(const v1::Localising& message) {
  Localising localising;
  localising.state =
      FromMessage(kLocalisationStates, message.state(), LocalisationState::kSearching);
  localising.tracking = FromMessage(message.tracking());
  localising.since_ns = message.since_ns();
  localising.received_ns = message.received_ns();
  localising.scans = message.scans();
  localising.rejected = message.rejected();
  return localising;
}

}  // namespace isthmus::convert
