#include "server/rpc/closed_reflection.h"

#include <absl/strings/match.h>

#include <string>

namespace isthmus::rpc {
namespace {

namespace exp = grpc::experimental;

class ReflectionCall final : public exp::Interceptor {
 public:
  ReflectionCall(Gate& gate, grpc::ServerContextBase& context) : gate_(gate), context_(context) {}

  void Intercept(exp::InterceptorBatchMethods* methods) override {
    std::string token;
    if (methods->QueryInterceptionHookPoint(
            exp::InterceptionHookPoints::POST_RECV_INITIAL_METADATA) &&
        !gate_.Admit(context_, "ServerReflectionInfo", &token).ok()) {
      context_.TryCancel();
    }
    methods->Proceed();
  }

 private:
  Gate& gate_;
  grpc::ServerContextBase& context_;
};

class ReflectionCalls final : public exp::ServerInterceptorFactoryInterface {
 public:
  explicit ReflectionCalls(Gate& gate) : gate_(gate) {}
  exp::Interceptor* CreateServerInterceptor(exp::ServerRpcInfo* info) override {
    if (!absl::StartsWith(info->method(), "/grpc.reflection.")) return nullptr;
    return new ReflectionCall(gate_, *info->server_context());
  }

 private:
  Gate& gate_;
};

}  // namespace

std::unique_ptr<exp::ServerInterceptorFactoryInterface> CloseReflection(Gate* gate) {
  return std::make_unique<ReflectionCalls>(*gate);
}

}  // namespace isthmus::rpc
