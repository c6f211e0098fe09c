function outside_client()
% A solver for studies: consimd sweep --solver 'mine=exec:octave-cli --quiet --norc --eval outside_client'.
% Put your own in `solve`.
  say('ready 1.0\n');
  header = fscanf(0, '%g', 3);
  while numel(header) == 3
    rows = fscanf(0, '%g', [6, header(1)]);
    pose = solve(rows(1:3, :), rows(4:6, :), header(2), header(3));
    if isempty(pose)
      say('none\n');
    else
      say([sprintf('%.17g ', pose'), '\n']);
    end
    header = fscanf(0, '%g', 3);
  end
end

function say(text)
  fprintf(text);
  if exist('OCTAVE_VERSION', 'builtin')
    fflush(stdout);  % which MATLAB neither has nor needs
  end
end

function pose = fit(p, q)
% 4 x 4 rigid motion of 3 x N points p to q, least squares (Umeyama 1991, eq. 40 to 42 without scale).
  a = mean(p, 2);
  b = mean(q, 2);
  [u, ~, v] = svd((q - b) * (p - a)');
  r = u * diag([1, 1, det(u * v')]) * v';
  pose = [r, b - r * a; 0, 0, 0, 1];
end

function pose = solve(source, target, noise_bound, seed)
% A pose, 4 x 4, for 3 x N points, or [] where there is none: here RANSAC on three points.
  pose = [];
  n = size(source, 2);
  if n < 3
    return
  end
  rng(seed);
  best = false(1, n);
  for sample = 1:200
    rows = randi(n, 1, 3);
    tried = fit(source(:, rows), target(:, rows));
    near = sqrt(sum((tried(1:3, 1:3) * source + tried(1:3, 4) - target) .^ 2, 1)) <= noise_bound;
    if sum(near) > sum(best)
      best = near;
    end
  end
  if sum(best) > 3
    pose = fit(source(:, best), target(:, best));
  end
end
