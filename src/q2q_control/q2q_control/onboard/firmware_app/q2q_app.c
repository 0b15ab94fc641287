/* One step of the app: measure the push, correct the model, predict for when the rotors will have answered.

     y = (R f_body)_z - lagged(T / m) b_z         measured push
     eta^ = eta(t + lag) + exp(-lag / T_r) r^(t)   with the lag of the rotors' thrust

   The law is explicit: acceleration = that of the setpoint - eta^. */
#include <math.h>
#include <string.h>

#include "q2q_track.h"

const uint32_t q2q_app_bytes = sizeof(struct q2q_app), q2q_neighbours = Q2Q_NEIGHBOURS;
const float q2q_acc_per_pwm = Q2Q_NEWTON_PER_PWM / Q2Q_MASS;

/* Jobs of a step: the predictions for the present and for when the rotors will have answered, and the strength of
   one source, if sources have one. */
enum { PRESENT, AHEAD, STRENGTH, JOBS = Q2Q_STACKS ? 3 : 2 };

static void restart(struct q2q_app *app) {
  memset(&app->correction, 0, sizeof app->correction);
  app->correction.variance = Q2Q_RESIDUAL_FLOOR * Q2Q_RESIDUAL_FLOOR;
}

void q2q_reset(struct q2q_app *app) {
  memset(app, 0, sizeof *app);
  for (int k = 0; k < Q2Q_VEHICLES; ++k) app->strength[k] = 1.0f;
  restart(app);
}

/* Return the time since the last step [s]: 0 in the first one, and where the clock was set back. */
static float since_last(struct q2q_app *app, uint32_t now_us) {
  const float dt = app->stepped ? q2q_seconds(app->last_us, now_us) : 0.0f;
  app->stepped = true;
  app->last_us = now_us;
  return dt > 0.0f ? dt : 0.0f;
}

/* Let the rotors follow the command. The vehicle flies from the moment when they carry it until none is commanded:
   the supervisor takes it as flying for 2 s longer, in which it may stand and take off again. */
static void follow(struct q2q_app *app, const struct q2q_input *input, float dt) {
  const float keep = Q2Q_THRUST_LAG_S > 0.0f ? expf(-dt / Q2Q_THRUST_LAG_S) : 0.0f;
  if (isfinite(input->thrust)) app->thrust = keep * app->thrust + (1.0f - keep) * input->thrust;
  const bool off = !input->flying || input->thrust <= 0.0f;
  app->flying = !off && (app->flying || app->thrust > Q2Q_LIFTED);
}

/* Do one of the jobs that take turns. */
static void work(struct q2q_app *app, const struct q2q_input *input) {
  const struct q2q_motion *own = &input->own;
  if (app->job == PRESENT) {
    app->eta = q2q_downwash(app, own, input->now_us, 0.0f);
  } else if (app->job == AHEAD) {
    app->ahead = q2q_downwash(app, own, input->now_us, Q2Q_THRUST_LAG_S);
  } else {
    app->source = (uint8_t)(app->source % Q2Q_NEIGHBOURS + 1);
    q2q_renew_strength(app, own, input->now_us, app->source);
  }
  app->job = (uint8_t)((app->job + 1) % JOBS);
}

float q2q_step(struct q2q_app *app, const struct q2q_input *input) {
  const float dt = since_last(app, input->now_us);
  struct q2q_track *own = &app->track[0];
  q2q_forget(app, input->now_us);
  if (own->count == 0 || q2q_seconds(own->stamp_us[own->newest], input->now_us) >= Q2Q_PERIOD_S)
    q2q_remember(own, input->now_us, &input->own);
  const bool placed = q2q_finite(&input->own);
  if (placed) work(app, input);
  follow(app, input, dt);
  if (!app->flying) {
    restart(app);
    return 0.0f;
  }
  const float carried = isfinite(input->thrust) ? app->thrust * input->own.axis[2] : NAN;
  q2q_measure(&app->correction, input->force_up - carried, app->eta, dt);
  const float all = app->ahead + q2q_residual(&app->correction, Q2Q_THRUST_LAG_S);
  if (!placed || !isfinite(all)) return 0.0f;
  return all > Q2Q_LARGEST ? Q2Q_LARGEST : all < -Q2Q_LARGEST ? -Q2Q_LARGEST : all;
}
