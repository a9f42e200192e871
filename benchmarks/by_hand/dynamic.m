% Fig 17 as a private script: both drives shaking a mass, whole arrays at once, no package.
%
% Run as: octave-cli --quiet --norc dynamic.m parameters.json result.bin
% Prints seconds as JSON; writes both performances, frequency by fraction, to result.bin.
1;

function performance = cobotic(p, frequency, fraction, phase)
  % Energy exchanged with the load over energy taken from the supply, braking burnt; frequency along the first axis,
  % fraction along the second, phase along the third.
  turn = 2 * pi * frequency;
  size = sqrt(2 * sqrt(2) * p.power * fraction ./ (p.load_mass * turn .^ 3));
  s = sin(phase); c = cos(phase);
  speed = size .* turn .* c;
  acceleration = -size .* turn .^ 2 .* s;
  jerk = -size .* turn .^ 3 .* c;
  snap = size .* turn .^ 4 .* s;
  out = p.load_mass * acceleration .* speed;

  slip_force = p.friction * p.preload;
  rolling_force = (p.rolling_torque + p.bearing_torque) / p.wheel_radius;
  surface_speed = p.cylinder_radius * p.cylinder_speed;
  h = rolling_force / slip_force;
  k = p.creep_stiffness / slip_force;
  mass = p.load_mass + p.link_mass;
  f = (mass * acceleration + p.guideway_coefficient * p.preload * sign(speed)) / slip_force;
  f1 = mass * jerk / slip_force;
  f2 = mass * snap / slip_force;
  q = speed / surface_speed;
  q1 = acceleration / surface_speed;
  q2 = jerk / surface_speed;

  t = -q;
  for step = 1:50
    e = (h * t - f .* sqrt(1 + t .* t)) / k;
    new = (e - q) ./ (1 + e .* q);
    moved = max(abs(new - t)(:));
    t = new;
    if moved < 1e-9
      break
    end
  end
  root = sqrt(1 + t .* t);
  x = h * t - f .* root;
  x(abs(x) > 1) = NaN;
  e = x / k;

  % G = t (1 + e q) - e + q = 0, differentiated twice by time.
  xt = h - f .* t ./ root;
  ge = t .* q - 1;
  gq = 1 + t .* e;
  gt = 1 + e .* q + ge .* xt / k;
  pull = -root .* f1;
  t1 = -(gq .* q1 + ge .* pull / k) ./ gt;
  e1 = (xt .* t1 + pull) / k;
  bend = -(f ./ (root .* root) .* t1 .* t1 + 2 * t .* t1 .* f1) ./ root - root .* f2;
  t2 = -(ge .* bend / k + gq .* q2 + 2 * t1 .* (e1 .* q + e .* q1) + 2 * t .* e1 .* q1) ./ gt;
  along = 1 ./ (1 + t .* t);
  phi1 = t1 .* along;
  phi2 = t2 .* along - 2 * t .* phi1 .* phi1;

  lateral = slip_force * x;
  torque = p.cylinder_radius * (lateral .* t ./ root + rolling_force ./ root);
  motor_speed = p.gear_ratio * p.cylinder_speed;
  current = (torque / p.gear_ratio + (1 - p.gear_efficiency) * p.continuous_torque) / p.torque_constant + p.no_load_current;
  drawn = max(current .* (current * p.resistance + p.torque_constant * motor_speed), 0) + 0 * current;

  way = sign(phi1);
  inertia = p.bell_inertia + p.steering_ratio ^ 2 * p.steering_rotor;
  steering_torque = (p.steering_friction * way + inertia * phi2) / p.steering_ratio;
  current = steering_torque / p.steering_constant + p.steering_no_load * way;
  voltage = current * p.steering_resistance + p.steering_constant * p.steering_ratio * phi1;
  drawn = drawn + max(current .* voltage, 0);
  performance = mean(abs(out), 3) ./ mean(drawn, 3);
end

function performance = conventional(p, frequency, fraction, phase)
  turn = 2 * pi * frequency;
  size = sqrt(2 * sqrt(2) * p.power * fraction ./ (p.load_mass * turn .^ 3));
  speed = size .* turn .* cos(phase);
  acceleration = -size .* turn .^ 2 .* sin(phase);
  out = p.load_mass * acceleration .* speed;
  way = sign(speed);
  torque = (p.load_mass * acceleration + p.drag * way) * p.pulley_radius + p.output_inertia / p.pulley_radius * acceleration;
  motor_speed = p.large_ratio / p.pulley_radius * speed;
  shaft = torque / p.large_ratio + (1 - p.large_efficiency) * p.large_torque * way ...
    + p.large_rotor * p.large_ratio / p.pulley_radius * acceleration;
  current = shaft / p.large_constant + p.large_no_load * way;
  voltage = current * p.large_resistance + p.large_constant * motor_speed;
  performance = mean(abs(out), 3) ./ mean(max(current .* voltage, 0), 3);
end

arguments = argv();
p = jsondecode(fileread(arguments{end - 1}));
frequency = p.frequency(:);
fraction = p.fraction(:)';
phase = reshape(2 * pi * ((0:p.samples - 1) + 0.5) / p.samples, 1, 1, []);
tic;
one = cobotic(p, frequency, fraction, phase);
other = conventional(p, frequency, fraction, phase);
seconds = toc;
file = fopen(arguments{end}, "w");
fwrite(file, one', "double");
fwrite(file, other', "double");
fclose(file);
printf("{\"seconds\": %.6f}\n", seconds);
